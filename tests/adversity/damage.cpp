#include "tests/adversity/damage.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate::adversity {
namespace {

using Eigen::Vector2d;

// Rows moved along x by what `shift` says of each [px].
void MoveRows(cv::Mat& picture, const std::function<double(int)>& shift) {
  cv::Mat x(picture.size(), CV_32F), y(picture.size(), CV_32F), moved;
  for (int row = 0; row < picture.rows; ++row) {
    const auto by = static_cast<float>(shift(row));
    y.row(row) = row;
    for (int column = 0; column < picture.cols; ++column) {
      x.at<float>(row, column) = static_cast<float>(column) - by;
    }
  }
  cv::remap(picture, moved, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  picture = moved;
}

cv::Rect RowsOf(const cv::Mat& picture, Part part, double share) {
  const int rows = static_cast<int>(share * picture.rows);
  return {0, part == Part::kUpper ? 0 : picture.rows - rows, picture.cols, rows};
}

cv::Rect Around(const Vector2d& p, const cv::Size& size) {
  return {static_cast<int>(std::lround(p.x())) - size.width / 2,
          static_cast<int>(std::lround(p.y())) - size.height / 2, size.width, size.height};
}
cv::Rect WholeOf(const cv::Mat& picture) {
  return {0, 0, picture.cols, picture.rows};
}

}  // namespace

Paint Smudge(double blur, double veil) {
  return [=](const View& view, cv::Mat& picture) {
    constexpr double kRadius = 45;
    cv::Mat smeared, mask(picture.size(), CV_32F, cv::Scalar(0)), sharp, mixed;
    cv::GaussianBlur(picture, smeared, {}, blur);
    smeared.convertTo(smeared, CV_32F, 1 - veil, veil * 150);
    cv::circle(mask, {cvRound(view.pressed_I.x()), cvRound(view.pressed_I.y())},
               cvRound(kRadius - 10), cv::Scalar(1), -1);
    cv::GaussianBlur(mask, mask, {}, 6);
    picture.convertTo(sharp, CV_32F);
    mixed = sharp + (smeared - sharp).mul(mask);
    mixed.convertTo(picture, CV_8U);
  };
}

Paint Dust(int count) {
  return [count](const View&, cv::Mat& picture) {
    std::mt19937_64 random(11);
    for (int i = 0; i < count; ++i) {
      const auto from = [&](int most) { return static_cast<int>(random() % std::max(1, most)); };
      const cv::Point at(from(picture.cols), from(picture.rows));
      cv::circle(picture, at, 2 + from(4), cv::Scalar(40 + from(60)), -1, cv::LINE_AA);
    }
  };
}

Paint Breathing(double factor) {
  return [factor](const View& view, cv::Mat& picture) {
    Zoom(1 + (factor - 1) * view.share(), When::kAlways)(view, picture);
  };
}

Paint TurnSlowly(double degrees) {
  return [degrees](const View& view, cv::Mat& picture) {
    Turn(degrees * view.share(), When::kAlways)(view, picture);
  };
}

Paint LoseFocus(double sigma) {
  return [sigma](const View& view, cv::Mat& picture) {
    if (view.index > 0) Defocus(sigma * view.share())(view, picture);
  };
}

Paint Haze(double veil) {
  return [veil](const View& view, cv::Mat& picture) {
    const double now = veil * view.share();
    picture.convertTo(picture, CV_8U, 1 - now, 235 * now);
  };
}

Paint Wobble(double px) {
  return [px](const View& view, cv::Mat& picture) {
    const double phase = 1.9 * static_cast<double>(view.index);
    MoveRows(picture, [=](int row) { return px * std::sin(row * 2 * M_PI / 120 + phase); });
  };
}

Paint Comb(double px) {
  return [px](const View&, cv::Mat& picture) {
    MoveRows(picture, [=](int row) { return row % 2 == 0 ? 0 : px; });
  };
}

Paint DeadRows(int count, double level) {
  return [=](const View& view, cv::Mat& picture) {
    const cv::Rect rows = Around(view.pressed_I, {4 * picture.cols, count});
    picture(rows & WholeOf(picture)) = level;
  };
}

Paint DeadColumns(int count, double level) {
  return [=](const View& view, cv::Mat& picture) {
    const cv::Rect columns = Around(view.pressed_I, {count, 4 * picture.rows});
    picture(columns & WholeOf(picture)) = level;
  };
}

Paint HotPixels(double share) {
  return [share](const View&, cv::Mat& picture) {
    std::mt19937_64 random(13);
    const auto count = static_cast<int>(share * static_cast<double>(picture.total()));
    for (int i = 0; i < count; ++i) {
      const auto at = random() % picture.total();
      const auto columns = static_cast<std::uint64_t>(picture.cols);
      picture.at<std::uint8_t>(static_cast<int>(at / columns), static_cast<int>(at % columns)) =
          255;
    }
  };
}

Paint Banding(double strength) {
  return [strength](const View& view, cv::Mat& picture) {
    const double phase = 2.1 * static_cast<double>(view.index);
    for (int row = 0; row < picture.rows; ++row) {
      cv::Mat line = picture.row(row);
      line.convertTo(line, CV_8U, 1 + strength * std::sin(row * 2 * M_PI / 40 + phase));
    }
  };
}

Paint OneSided(double strength) {
  return [strength](const View&, cv::Mat& picture) {
    for (int column = 0; column < picture.cols; ++column) {
      cv::Mat line = picture.col(column);
      line.convertTo(line, CV_8U, 1 + strength * (2.0 * column / picture.cols - 1));
    }
  };
}

Paint Quantised(int levels) {
  return [levels](const View&, cv::Mat& picture) {
    cv::Mat table(1, 256, CV_8U);
    const double step = 256.0 / levels;
    for (int i = 0; i < 256; ++i) {
      table.at<std::uint8_t>(i) =
          cv::saturate_cast<std::uint8_t>((std::floor(i / step) + 0.5) * step);
    }
    cv::LUT(picture, table, picture);
  };
}

Paint Inverted() {
  return [](const View&, cv::Mat& picture) { cv::bitwise_not(picture, picture); };
}

Mask PartlyOld(Part part, double share, int side) {
  return [=](const Moment& moment, cv::Mat& mask) {
    if (side < 0 || moment.side == side) mask(RowsOf(mask, part, share)) = 255;
  };
}

Paint PartlyGrey(Part part, double share) {
  return [=](const View&, cv::Mat& picture) { picture(RowsOf(picture, part, share)) = 128; };
}

Mask BlocksLost(double share) {
  return [share](const Moment& moment, cv::Mat& mask) {
    constexpr int kEdge = 16;
    std::mt19937_64 random(moment.index * 2 + static_cast<std::size_t>(moment.side) + 17);
    for (int y = 0; y < mask.rows; y += kEdge) {
      for (int x = 0; x < mask.cols; x += kEdge) {
        if (std::uniform_real_distribution<double>(0, 1)(random) >= share) continue;
        mask(cv::Rect(x, y, kEdge, kEdge) & WholeOf(mask)) = 255;
      }
    }
  };
}

Paint Mirrored(int flip_code) {
  return [flip_code](const View&, cv::Mat& picture) { cv::flip(picture, picture, flip_code); };
}

Paint Resized(double factor) {
  return [factor](const View&, cv::Mat& picture) {
    cv::resize(picture, picture, {}, factor, factor, cv::INTER_AREA);
  };
}

Paint SecondTool(double aside) {
  return [aside](const View& view, cv::Mat& picture) {
    const Vector2d across(-view.shaft_I.y(), view.shaft_I.x());
    const int edge = std::max(8, cvRound(view.width));
    const cv::Mat before = picture.clone();
    // In squares along the shaft, from the tip on.
    for (int piece = 0; piece < 300 / edge; ++piece) {
      const Vector2d at = view.tip_I + (piece + 0.5) * edge * view.shaft_I;
      const cv::Size size(edge + 2, edge + 2);
      const cv::Rect from = Around(at, size), to = Around(at + aside * across, size);
      const bool inside = (from & WholeOf(picture)) == from && (to & WholeOf(picture)) == to;
      if (inside) before(from).copyTo(picture(to));
    }
  };
}

Paint Neighbour(double beside) {
  return [beside](const View& view, cv::Mat& picture) {
    constexpr int kEdge = 80;
    const Vector2d across(-view.shaft_I.y(), view.shaft_I.x());
    const Vector2d at =
        view.pressed_I + (beside + kEdge / 2.0) * across - kEdge / 2.0 * view.shaft_I;
    picture(Around(at, {kEdge, kEdge}) & WholeOf(picture)) = 110;
  };
}

Paint MovingWire(double width) {
  return [width](const View& view, cv::Mat& picture) {
    Wire(width, 20, 160 * (view.share() - 0.5))(view, picture);
  };
}

}  // namespace palpate::adversity
