#include "slave/vision/snake.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace palpate {
namespace {

// A 3 x 3 gradient at the nine places needs this much [px]. [tuned: StaysInsideTheImage]
constexpr int kBorder = 2;
constexpr double kMinRange =
    5;  // [grey levels] [paper: Williams and Shah, a smaller range is flat]
constexpr double kCornerBend =
    0.25;  // |u_i - u_{i+1}|^2 of unit tangents [-] [paper: Williams and Shah]
constexpr double kCornerStrength = 0.5;           // of the mean edge strength
constexpr double kStrongEdge = 50, kMaxGain = 8;  // gradient that counts as strong; amplification
// Side / mean side that is too long. [-] [tuned: CreepsOntoADiscFromOutsideAndInside]
constexpr double kGap = 1.7;
constexpr double kStillMoving = 0.04;  // share of the points that may still move at the end

}  // namespace

GreedyStep EvaluateStep(const Eigen::Vector2d& previous, const Eigen::Vector2d& v,
                        const Eigen::Vector2d& next, double mean_spacing,
                        const SnakeWeights& weights, const NinePlaces& magnitude) noexcept {
  GreedyStep step;
  const Eigen::Vector2d neighbours = previous + next;
  double cont_max = 0, curv_max = 0;
  for (std::size_t k = 0; k < 9; ++k) {
    const Eigen::Vector2d place(v.x() + static_cast<double>(k / 3) - 1,
                                v.y() + static_cast<double>(k % 3) - 1);
    step.cont[k] = std::abs(mean_spacing - (place - previous).norm());
    step.curv[k] = (neighbours - 2 * place).squaredNorm();
    cont_max = std::max(cont_max, step.cont[k]);
    curv_max = std::max(curv_max, step.curv[k]);
  }
  const auto [low, high] = std::minmax_element(magnitude.begin(), magnitude.end());
  const double range = std::max(*high - *low, kMinRange);
  const double bottom = *high - range;
  for (std::size_t k = 0; k < 9; ++k) {
    if (cont_max > 0) step.cont[k] /= cont_max;
    if (curv_max > 0) step.curv[k] /= curv_max;
    step.image[k] = (bottom - magnitude[k]) / range;
    step.total[k] =
        weights.alpha * step.cont[k] + weights.beta * step.curv[k] + weights.gamma * step.image[k];
  }
  for (std::size_t k = 0; k < 9; ++k) {
    if (step.total[k] < step.total[static_cast<std::size_t>(step.best)]) {
      step.best = static_cast<int>(k);
    }
  }
  return step;
}

Snake::Snake(const GreyFormat& format, const SnakeWeights& weights, CurveView start,
             int control_points)
    : format_(format), weights_(weights) {
  points_ = Resample(start, control_points);
  for (Eigen::Vector2d& p : points_) p = Clamped(p);
  strength_.assign(points_.size(), 0);
  bend_.assign(points_.size(), 0);
  beta_.assign(points_.size(), weights_.beta);
}

Eigen::Vector2d Snake::Clamped(const Eigen::Vector2d& v) const noexcept {
  const Eigen::Vector2d last(format_.size().width - 1 - kBorder,
                             format_.size().height - 1 - kBorder);
  return v.array().round().matrix().cwiseMin(last).cwiseMax(kBorder);
}

int Snake::Creep(const cv::Mat& image, int max_rounds) {
  const int at_rest = static_cast<int>(kStillMoving * static_cast<double>(points_.size()));
  for (int round = 1; round <= max_rounds; ++round) {
    const bool rests = CreepRound(image) <= at_rest;
    EvenOut();
    if (rests) return round;
    RelaxCorners();
  }
  return max_rounds;
}

void Snake::AdaptTo(const cv::Mat& image) noexcept {
  gain_ = 1;
  double sum = 0;
  for (const Eigen::Vector2d& p : points_) {
    const NinePlaces magnitude = MagnitudeAround(image, p);
    sum += *std::max_element(magnitude.begin(), magnitude.end());
  }
  const double mean = sum / static_cast<double>(points_.size());
  gain_ = std::clamp(kStrongEdge / std::max(mean, 1.0), 1.0, kMaxGain);
}

void Snake::EvenOut() {
  const std::size_t n = points_.size();
  double longest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    longest = std::max(longest, (points_[(i + 1) % n] - points_[i]).norm());
  }
  if (longest <= kGap * CurveLength(points_) / static_cast<double>(n)) return;
  points_ = Resample(points_, static_cast<int>(n));
  for (Eigen::Vector2d& p : points_) p = Clamped(p);
}

int Snake::CreepRound(const cv::Mat& image) noexcept {
  const std::size_t n = points_.size();
  const double spacing = CurveLength(points_) / static_cast<double>(n);
  int moved = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const NinePlaces magnitude = MagnitudeAround(image, points_[i]);
    const SnakeWeights weights{weights_.alpha, beta_[i], weights_.gamma};
    const GreedyStep step = EvaluateStep(points_[(i + n - 1) % n], points_[i], points_[(i + 1) % n],
                                         spacing, weights, magnitude);
    strength_[i] = magnitude[static_cast<std::size_t>(step.best)];
    const Eigen::Vector2d place = Clamped(points_[i] + Eigen::Vector2d(step.dx(), step.dy()));
    moved += place != points_[i] ? 1 : 0;
    points_[i] = place;
  }
  return moved;
}

// Sobel's gradient / 4: the difference of grey levels over two pixels, smoothed across.
NinePlaces Snake::MagnitudeAround(const cv::Mat& image, const Eigen::Vector2d& v) const noexcept {
  std::array<std::int16_t, 25> near;  // 5 x 5 around v
  format_.Read(image, cv::Rect(static_cast<int>(v.x()) - 2, static_cast<int>(v.y()) - 2, 5, 5),
               near.data());
  const double unit = gain_ / (4 * format_.levels_per_255());
  NinePlaces magnitude;
  for (std::size_t k = 0; k < 9; ++k) {
    const std::int16_t* c = near.data() + 6 + (k / 3) + 5 * (k % 3);
    const int gx = c[-4] + 2 * c[1] + c[6] - c[-6] - 2 * c[-1] - c[4];
    const int gy = c[4] + 2 * c[5] + c[6] - c[-6] - 2 * c[-5] - c[-4];
    magnitude[k] = unit * std::sqrt(static_cast<double>(gx * gx + gy * gy));
  }
  return magnitude;
}

// A point is a corner where the chain bends more than at both neighbours and there is an edge.
void Snake::RelaxCorners() noexcept {
  const std::size_t n = points_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d in = points_[i] - points_[(i + n - 1) % n];
    const Eigen::Vector2d out = points_[(i + 1) % n] - points_[i];
    bend_[i] = (in.normalized() - out.normalized()).squaredNorm();
  }
  const double mean_strength =
      std::accumulate(strength_.begin(), strength_.end(), 0.0) / static_cast<double>(n);
  const double least = kCornerStrength * mean_strength;
  for (std::size_t i = 0; i < n; ++i) {
    const bool sharpest = bend_[i] > bend_[(i + n - 1) % n] && bend_[i] > bend_[(i + 1) % n];
    const bool corner = sharpest && bend_[i] > kCornerBend && strength_[i] > least;
    beta_[i] = corner ? 0 : weights_.beta;
  }
}

}  // namespace palpate
