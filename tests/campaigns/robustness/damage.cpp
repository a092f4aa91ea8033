#include "tests/campaigns/robustness/damage.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate::robustness {
namespace {

using Eigen::Vector2d;

// Moves each row along x by `shift` of the row [px].
void MoveRows(cv::Mat& image, const std::function<double(int)>& shift) {
  cv::Mat x(image.size(), CV_32F), y(image.size(), CV_32F), moved;
  for (int row = 0; row < image.rows; ++row) {
    const auto by = static_cast<float>(shift(row));
    y.row(row) = row;
    for (int column = 0; column < image.cols; ++column) {
      x.at<float>(row, column) = static_cast<float>(column) - by;
    }
  }
  cv::remap(image, moved, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  image = moved;
}

cv::Rect RowsOf(const cv::Mat& image, Part part, double share) {
  const int rows = static_cast<int>(share * image.rows);
  return {0, part == Part::kUpper ? 0 : image.rows - rows, image.cols, rows};
}

cv::Rect Around(const Vector2d& p, const cv::Size& size) {
  return {static_cast<int>(std::lround(p.x())) - size.width / 2,
          static_cast<int>(std::lround(p.y())) - size.height / 2, size.width, size.height};
}
cv::Rect WholeOf(const cv::Mat& image) {
  return {0, 0, image.cols, image.rows};
}

}  // namespace

Paint Smudge(double blur, double veil) {
  return [=](const View& view, cv::Mat& image) {
    constexpr double kRadius = 45;
    cv::Mat smeared, mask(image.size(), CV_32F, cv::Scalar(0)), sharp, mixed;
    cv::GaussianBlur(image, smeared, {}, blur);
    smeared.convertTo(smeared, CV_32F, 1 - veil, veil * 150);
    cv::circle(mask, {cvRound(view.pressed_I.x()), cvRound(view.pressed_I.y())},
               cvRound(kRadius - 10), cv::Scalar(1), -1);
    cv::GaussianBlur(mask, mask, {}, 6);
    image.convertTo(sharp, CV_32F);
    mixed = sharp + (smeared - sharp).mul(mask);
    mixed.convertTo(image, CV_8U);
  };
}

Paint Dust(int count) {
  return [count](const View&, cv::Mat& image) {
    std::mt19937_64 random(11);
    for (int i = 0; i < count; ++i) {
      const auto from = [&](int most) { return static_cast<int>(random() % std::max(1, most)); };
      const cv::Point at(from(image.cols), from(image.rows));
      cv::circle(image, at, 2 + from(4), cv::Scalar(40 + from(60)), -1, cv::LINE_AA);
    }
  };
}

Paint Breathing(double factor) {
  return [factor](const View& view, cv::Mat& image) {
    Zoom(1 + (factor - 1) * view.share(), When::kAlways)(view, image);
  };
}

Paint TurnSlowly(double degrees) {
  return [degrees](const View& view, cv::Mat& image) {
    Turn(degrees * view.share(), When::kAlways)(view, image);
  };
}

Paint LoseFocus(double sigma) {
  return [sigma](const View& view, cv::Mat& image) {
    if (view.index > 0) Defocus(sigma * view.share())(view, image);
  };
}

Paint Haze(double veil) {
  return [veil](const View& view, cv::Mat& image) {
    const double now = veil * view.share();
    image.convertTo(image, CV_8U, 1 - now, 235 * now);
  };
}

Paint Fog(double veil) {
  return [veil](const View& view, cv::Mat& image) {
    constexpr double kEdge = 25;  // soft [px]
    const double now = veil * view.share();
    for (int column = 0; column < image.cols; ++column) {
      const double here = now / (1 + std::exp(-(column - view.pressed_I.x()) / kEdge));
      cv::Mat line = image.col(column);
      line.convertTo(line, CV_8U, 1 - here, 200 * here);
    }
  };
}

Paint Droplet(double pull) {
  return [pull](const View& view, cv::Mat& image) {
    constexpr double kRadius = 40;
    const Vector2d middle = view.pressed_I + Vector2d(15, 5);
    cv::Mat x(image.size(), CV_32F), y(image.size(), CV_32F), moved;
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        const Vector2d away = (Vector2d(column, row) - middle) / kRadius;
        const double r2 = away.squaredNorm();
        // The factor is 1 at half the radius and 0 at the centre and at the edge.
        const double part = r2 < 1 ? 16.0 / 9 * (1 - r2) * (1 - r2) * 2 : 0;
        x.at<float>(row, column) = static_cast<float>(column - pull * part * away.x());
        y.at<float>(row, column) = static_cast<float>(row - pull * part * away.y());
      }
    }
    cv::remap(image, moved, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    image = moved;
  };
}

Paint Ghost(double share) {
  return [share](const View&, cv::Mat& image) {
    cv::Mat aside, mixed;
    const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, 14, 0, 1, 5);
    cv::warpAffine(image, aside, shift, image.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    cv::addWeighted(image, 1 - share, aside, share, 0, mixed);
    image = mixed;
  };
}

Paint HeatHaze(double sigma) {
  return [sigma](const View& view, cv::Mat& image) {
    constexpr int kCell = 24;  // [px]
    cv::RNG random(view.index * 2 + static_cast<std::size_t>(view.side) + 23);
    cv::Mat coarse(image.rows / kCell + 2, image.cols / kCell + 2, CV_32FC2), by, moved;
    random.fill(coarse, cv::RNG::NORMAL, 0, sigma);
    cv::resize(coarse, by, image.size(), 0, 0, cv::INTER_CUBIC);
    for (int y = 0; y < by.rows; ++y) {
      for (int x = 0; x < by.cols; ++x) {
        by.at<cv::Vec2f>(y, x) += cv::Vec2f(static_cast<float>(x), static_cast<float>(y));
      }
    }
    cv::remap(image, moved, by, cv::Mat(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    image = moved;
  };
}

Paint Wobble(double px) {
  return [px](const View& view, cv::Mat& image) {
    const double phase = 1.9 * static_cast<double>(view.index);
    MoveRows(image, [=](int row) { return px * std::sin(row * 2 * M_PI / 120 + phase); });
  };
}

Paint Comb(double px) {
  return [px](const View&, cv::Mat& image) {
    MoveRows(image, [=](int row) { return row % 2 == 0 ? 0 : px; });
  };
}

Paint DeadRows(int count, double level) {
  return [=](const View& view, cv::Mat& image) {
    const cv::Rect rows = Around(view.pressed_I, {4 * image.cols, count});
    image(rows & WholeOf(image)) = level;
  };
}

Paint DeadColumns(int count, double level) {
  return [=](const View& view, cv::Mat& image) {
    const cv::Rect columns = Around(view.pressed_I, {count, 4 * image.rows});
    image(columns & WholeOf(image)) = level;
  };
}

Paint HotPixels(double share) {
  return [share](const View&, cv::Mat& image) {
    std::mt19937_64 random(13);
    const auto count = static_cast<int>(share * static_cast<double>(image.total()));
    for (int i = 0; i < count; ++i) {
      const auto at = random() % image.total();
      const auto columns = static_cast<std::uint64_t>(image.cols);
      image.at<std::uint8_t>(static_cast<int>(at / columns), static_cast<int>(at % columns)) = 255;
    }
  };
}

Paint Banding(double strength) {
  return [strength](const View& view, cv::Mat& image) {
    const double phase = 2.1 * static_cast<double>(view.index);
    for (int row = 0; row < image.rows; ++row) {
      cv::Mat line = image.row(row);
      line.convertTo(line, CV_8U, 1 + strength * std::sin(row * 2 * M_PI / 40 + phase));
    }
  };
}

Paint OneSided(double strength) {
  return [strength](const View&, cv::Mat& image) {
    for (int column = 0; column < image.cols; ++column) {
      cv::Mat line = image.col(column);
      line.convertTo(line, CV_8U, 1 + strength * (2.0 * column / image.cols - 1));
    }
  };
}

Paint Quantised(int levels) {
  return [levels](const View&, cv::Mat& image) {
    cv::Mat table(1, 256, CV_8U);
    const double step = 256.0 / levels;
    for (int i = 0; i < 256; ++i) {
      table.at<std::uint8_t>(i) =
          cv::saturate_cast<std::uint8_t>((std::floor(i / step) + 0.5) * step);
    }
    cv::LUT(image, table, image);
  };
}

Paint RollingGain(double strength) {
  return [strength](const View& view, cv::Mat& image) {
    const double phase = 1.3 * static_cast<double>(view.index);
    for (int row = 0; row < image.rows; ++row) {
      cv::Mat line = image.row(row);
      line.convertTo(line, CV_8U, 1 + strength * std::sin(row * 2 * M_PI / image.rows - phase));
    }
  };
}

Paint StuckRows(int count) {
  return [count](const View& view, cv::Mat& image) {
    const int from = std::clamp(cvRound(view.pressed_I.y()), 0, image.rows - 1);
    for (int row = from + 1; row < std::min(from + 1 + count, image.rows); ++row) {
      image.row(from).copyTo(image.row(row));
    }
  };
}

Paint DeadClusters(int count) {
  return [count](const View&, cv::Mat& image) {
    std::mt19937_64 random(19);
    const auto from = [&](int most) { return static_cast<int>(random() % std::max(1, most)); };
    for (int i = 0; i < count; ++i) {
      const cv::Rect cluster(from(image.cols), from(image.rows), 3 + from(5), 3 + from(5));
      image(cluster & WholeOf(image)) = 0;
    }
  };
}

Paint Moire(double levels) {
  return [levels](const View&, cv::Mat& image) {
    cv::Mat waves(image.size(), CV_32F), mixed;
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        waves.at<float>(y, x) =
            static_cast<float>(levels * std::sin((x + 0.3 * y) * 2 * M_PI / 2.7) *
                               std::sin((y - 0.4 * x) * 2 * M_PI / 31));
      }
    }
    cv::add(image, waves, mixed, cv::noArray(), CV_8U);
    image = mixed;
  };
}

Paint Inverted() {
  return [](const View&, cv::Mat& image) { cv::bitwise_not(image, image); };
}

Mask PartlyOld(Part part, double share, int side) {
  return [=](const Moment& moment, cv::Mat& mask) {
    if (side < 0 || moment.side == side) mask(RowsOf(mask, part, share)) = 255;
  };
}

Paint PartlyGrey(Part part, double share) {
  return [=](const View&, cv::Mat& image) { image(RowsOf(image, part, share)) = 128; };
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
  return [flip_code](const View&, cv::Mat& image) { cv::flip(image, image, flip_code); };
}

Paint Resized(double factor) {
  return [factor](const View&, cv::Mat& image) {
    cv::resize(image, image, {}, factor, factor, cv::INTER_AREA);
  };
}

Paint SecondTool(double aside) {
  return [aside](const View& view, cv::Mat& image) {
    const Vector2d across(-view.shaft_I.y(), view.shaft_I.x());
    const int edge = std::max(8, cvRound(view.width));
    const cv::Mat before = image.clone();
    // Copies squares along the shaft, starting at the tip.
    for (int piece = 0; piece < 300 / edge; ++piece) {
      const Vector2d at = view.tip_I + (piece + 0.5) * edge * view.shaft_I;
      const cv::Size size(edge + 2, edge + 2);
      const cv::Rect from = Around(at, size), to = Around(at + aside * across, size);
      const bool inside = (from & WholeOf(image)) == from && (to & WholeOf(image)) == to;
      if (inside) before(from).copyTo(image(to));
    }
  };
}

Paint Neighbour(double beside) {
  return [beside](const View& view, cv::Mat& image) {
    constexpr int kEdge = 80;
    const Vector2d across(-view.shaft_I.y(), view.shaft_I.x());
    const Vector2d at =
        view.pressed_I + (beside + kEdge / 2.0) * across - kEdge / 2.0 * view.shaft_I;
    image(Around(at, {kEdge, kEdge}) & WholeOf(image)) = 110;
  };
}

Paint Rain(int count) {
  return [count](const View& view, cv::Mat& image) {
    std::mt19937_64 random(view.index * 2 + static_cast<std::size_t>(view.side) + 29);
    const auto from = [&](int most) { return static_cast<int>(random() % std::max(1, most)); };
    cv::Mat streaks(image.size(), CV_8U, cv::Scalar(0));
    for (int i = 0; i < count; ++i) {
      const cv::Point top(from(image.cols), from(image.rows));
      cv::line(streaks, top, top + cv::Point(6, 30), cv::Scalar(40 + from(60)), 2, cv::LINE_AA);
    }
    image += streaks;
  };
}

Paint Insect(double size) {
  return [size](const View& view, cv::Mat& image) {
    // A winding path that passes the tip's position at full depth in the middle of the run.
    const double way = view.share() - 0.5;
    const Vector2d at = view.pressed_I + Vector2d(220 * way, 120 * way + 15 * std::sin(30 * way));
    const cv::Point middle(cvRound(at.x()), cvRound(at.y()));
    cv::ellipse(image, middle, {cvRound(size), cvRound(0.6 * size)}, 30, 0, 360, cv::Scalar(35), -1,
                cv::LINE_AA);
    for (int leg = 0; leg < 6; ++leg) {
      const double angle = leg * M_PI / 3 + 0.3 * std::sin(2.0 * static_cast<double>(view.index));
      const cv::Point foot(cvRound(1.8 * size * std::cos(angle)),
                           cvRound(1.8 * size * std::sin(angle)));
      cv::line(image, middle, middle + foot, cv::Scalar(35), 1, cv::LINE_AA);
    }
  };
}

Paint MovingWire(double width) {
  return [width](const View& view, cv::Mat& image) {
    Wire(width, 20, 160 * (view.share() - 0.5))(view, image);
  };
}

}  // namespace palpate::robustness
