#include "slave/vision/circle_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

constexpr double kWorkingEdge = 160;  // [px]
constexpr int kDirections = 32;
constexpr double kRadiusStep = 1.08, kSmallest = 0.02;
constexpr double kLeastVote = 0.15;  // 1: a strong edge all round

struct Vote {
  cv::Point centre;
  double radius = 0, vote = 0;
};

// The gradient with its magnitude bent to 0 ... 1, so that no strong edge outvotes many weak ones.
cv::Mat BentGradient(const cv::Mat& picture) {
  cv::Mat gx, gy;
  cv::Sobel(picture, gx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(picture, gy, CV_32F, 0, 1, 3, 0.125);
  cv::Mat magnitude;
  cv::magnitude(gx, gy, magnitude);
  const auto half = static_cast<float>(2 * cv::mean(magnitude)[0] + 0.1);
  cv::Mat bent(picture.size(), CV_32FC2);
  for (int y = 0; y < bent.rows; ++y) {
    for (int x = 0; x < bent.cols; ++x) {
      const float scale = 1 / (magnitude.at<float>(y, x) + half);
      bent.at<cv::Vec2f>(y, x) = {scale * gx.at<float>(y, x), scale * gy.at<float>(y, x)};
    }
  }
  return bent;
}

struct Rim {
  std::array<cv::Point, kDirections> offsets;
  std::array<cv::Vec2f, kDirections> normals;
  explicit Rim(double radius) {
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kDirections;
      normals[k] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
      offsets[k] = {cvRound(radius * normals[k][0]), cvRound(radius * normals[k][1])};
    }
  }
};

// The best radius for every centre.
std::vector<Vote> VoteEverywhere(const cv::Mat& bent) {
  std::vector<Vote> best(bent.total());
  const double largest = 0.5 * std::min(bent.cols, bent.rows) - 1;
  for (double r = std::max(3.0, kSmallest * std::max(bent.cols, bent.rows)); r < largest;
       r *= kRadiusStep) {
    const Rim rim(r);
    const int margin = static_cast<int>(r) + 1;
    for (int y = margin; y < bent.rows - margin; ++y) {
      for (int x = margin; x < bent.cols - margin; ++x) {
        float sum = 0;
        for (std::size_t k = 0; k < kDirections; ++k) {
          const auto& g = bent.at<cv::Vec2f>(cv::Point(x, y) + rim.offsets[k]);
          sum += g[0] * rim.normals[k][0] + g[1] * rim.normals[k][1];
        }
        // Larger circles are harder to come by.
        const double vote = std::abs(sum) / kDirections * std::sqrt(r / kWorkingEdge * 8);
        Vote& here = best[static_cast<std::size_t>(y * bent.cols + x)];
        if (vote > here.vote) here = {{x, y}, r, vote};
      }
    }
  }
  return best;
}

}  // namespace

std::vector<RoundEdge> FindRoundEdges(const cv::Mat& picture, std::size_t count) {
  const double scale = std::min(1.0, kWorkingEdge / std::max(picture.cols, picture.rows));
  cv::Mat working = picture;
  if (scale < 1) cv::resize(picture, working, {}, scale, scale, cv::INTER_AREA);
  std::vector<Vote> votes = VoteEverywhere(BentGradient(working));
  std::sort(votes.begin(), votes.end(),
            [](const Vote& a, const Vote& b) { return a.vote > b.vote; });
  std::vector<Vote> kept;
  for (const Vote& vote : votes) {
    if (kept.size() == count || vote.vote < kLeastVote) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Vote& other) {
      return cv::norm(vote.centre - other.centre) < 0.15 * other.radius + 1;
    });
    if (!known) kept.push_back(vote);
  }
  std::vector<RoundEdge> circles;
  for (const Vote& vote : kept) {
    circles.push_back({{(vote.centre.x + 0.5) / scale - 0.5, (vote.centre.y + 0.5) / scale - 0.5},
                       vote.radius / scale});
  }
  return circles;
}

}  // namespace palpate
