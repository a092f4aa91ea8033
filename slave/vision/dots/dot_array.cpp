#include "slave/vision/dots/dot_array.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

constexpr std::size_t kNeighbours = 8;  // [-] [tuned: IsIdentifiedTurnedShiftedAndTilted]
// Largest distance of a dot from its expected position in spacings [-]; at a half the next dot is
// as near. [tuned: MissingAndSpuriousDotsDoNotMixIdentities]
constexpr double kGate = 0.35;
constexpr double kShift = 2;          // largest shift of the whole array, in spacings [-]
constexpr double kAreaRatio = 2.5;    // largest ratio of a dot's areas in two images [-]
constexpr std::size_t kAnchors = 5;   // [-] [tuned: MissingAndSpuriousDotsDoNotMixIdentities]
constexpr int kNeighbourRounds = 12;  // rounds in which found neighbours predict further dots

// Number of additional dots that make a shift more likely than none, because spurious dots may fit
// by chance.
int Slack(std::size_t dots) {
  return static_cast<int>(dots / 12);
}

bool Alike(double area, double other) {
  return area < kAreaRatio * other && other < kAreaRatio * area;
}

// Extrapolates a point from its neighbours' motion: a weighted least-squares affine map, in which
// nearer ones have more weight. Collinear neighbours, or fewer than three, do not determine
// deformation across their line; there only a shift is used.
class AffineMotion {
 public:
  explicit AffineMotion(const Eigen::Vector2d& point) : point_(point) {}

  void Add(const Eigen::Vector2d& before, const Eigen::Vector2d& now) {
    const Eigen::Vector2d d = before - point_, motion = now - before;
    const double weight = 1 / (d.squaredNorm() + 1e-12);
    ++count_;
    sum_ += weight;
    d_ += weight * d;
    motion_ += weight * motion;
    dd_ += weight * d * d.transpose();
    motion_d_ += weight * motion * d.transpose();
  }
  [[nodiscard]] int count() const { return count_; }
  // Returns the present position of the point; NaN without neighbours.
  [[nodiscard]] Eigen::Vector2d Now() const {
    const Eigen::Vector2d d = d_ / sum_, motion = motion_ / sum_;
    const Eigen::Matrix2d ridge = 1e-6 * dd_.trace() * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d D = dd_ - sum_ * d * d.transpose() + ridge;
    if (count_ > 0 && !(D.determinant() > 0)) return point_ + motion;
    return point_ + motion - (motion_d_ - sum_ * motion * d.transpose()) * D.inverse() * d;
  }

 private:
  Eigen::Vector2d point_;
  int count_ = 0;
  double sum_ = 0;
  Eigen::Vector2d d_{0, 0}, motion_{0, 0};
  Eigen::Matrix2d dd_ = Eigen::Matrix2d::Zero(), motion_d_ = Eigen::Matrix2d::Zero();
};

// Returns the layout's indices, nearest to `p` first.
std::vector<int> ByDistance(const std::vector<Eigen::Vector2d>& layout, const Eigen::Vector2d& p) {
  std::vector<int> order(layout.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return (layout[Index(a)] - p).norm() < (layout[Index(b)] - p).norm();
  });
  return order;
}

Eigen::Vector2d MeanOf(const std::vector<Eigen::Vector2d>& layout) {
  Eigen::Vector2d mean(0, 0);
  for (const Eigen::Vector2d& p : layout) mean += p / static_cast<double>(layout.size());
  return mean;
}

bool IsCollinear(const std::vector<Eigen::Vector2d>& layout) {
  constexpr double kFlat = 1e-3;  // ratio of width and length of a flat array [-]
  const Eigen::Vector2d mean = MeanOf(layout);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : layout) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(spread, Eigen::EigenvaluesOnly);
  return !(eigen.eigenvalues()(0) > kFlat * kFlat * eigen.eigenvalues()(1));
}

}  // namespace

DotArray::DotArray(std::vector<Eigen::Vector2d> layout) : layout_(std::move(layout)) {
  const std::size_t n = layout_.size();
  if (n < 3 || n > 400) {
    throw std::invalid_argument(std::to_string(n) + " dots: expected 3 to 400");
  }
  for (const Eigen::Vector2d& p : layout_) {
    if (!p.allFinite()) throw std::invalid_argument("a dot of the layout has no finite position");
  }
  for (const Eigen::Vector2d& p : layout_) {
    const std::vector<int> order = ByDistance(layout_, p);
    const auto last = static_cast<std::ptrdiff_t>(std::min(n, kNeighbours + 1));
    neighbours_.emplace_back(order.begin() + 1, order.begin() + last);
  }
  const std::vector<int> outwards = ByDistance(layout_, MeanOf(layout_));
  for (std::size_t k = 0; k < n; k += (n + kAnchors - 1) / kAnchors) {
    anchors_.push_back(Index(outwards[k]));
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (!(Spacing(k, layout_) > 0)) {
      throw std::invalid_argument("two dots of the layout have the same position");
    }
  }
  if (IsCollinear(layout_)) throw std::invalid_argument("the dots of the layout lie on one line");
}

struct DotArray::Image {
  std::span<const Dot> dots;
  Places places;                 // expected positions of the array's dots
  std::vector<double> spacings;  // local spacings at those places
  std::span<const double> areas;
};

int DotArray::Identify(std::span<const Dot> dots, std::span<const Eigen::Vector2d> places,
                       std::span<const double> areas, std::vector<int>* picks) const {
  picks->assign(size(), kNoDot);
  if (places.size() != size() || areas.size() != size()) return 0;
  Image image{dots, {places.begin(), places.end()}, {}, areas};
  for (std::size_t k = 0; k < size(); ++k) image.spacings.push_back(Spacing(k, places));
  const int all = static_cast<int>(std::min(size(), dots.size()));
  int most = 0;
  std::vector<int> trial;
  const auto offer = [&](std::size_t anchor, const Eigen::Vector2d& shift, int margin) {
    const int found = Grow(image, anchor, shift, &trial);
    if (found > most + margin) most = found, *picks = trial;
  };
  for (const std::size_t anchor : anchors_) {
    if (most == all) break;
    offer(anchor, {0, 0}, 0);
    for (const Dot& dot : dots) {
      const Eigen::Vector2d shift = dot.centre - places[anchor];
      const double spacings = shift.norm() / image.spacings[anchor];
      if (most < all && spacings > kGate && spacings < kShift) offer(anchor, shift, Slack(size()));
    }
  }
  return most;
}

// Identifies dots from the anchor and its neighbours outwards; found dots predict the position of
// the next ones.
int DotArray::Grow(const Image& image, std::size_t anchor, const Eigen::Vector2d& shift,
                   std::vector<int>* picks) const {
  Places expected(size(), Eigen::Vector2d::Constant(std::nan("")));
  expected[anchor] = image.places[anchor] + shift;
  for (const int k : neighbours_[anchor]) expected[Index(k)] = image.places[Index(k)] + shift;
  int found = Assign(image, expected, picks);
  std::vector<int> trial;
  for (int round = 0; round < kNeighbourRounds && found >= 3; ++round) {
    const int more = Assign(image, Adapted(image, *picks), &trial);
    if (more < found || trial == *picks) break;
    found = more;
    *picks = trial;
  }
  return found;
}

// Returns the position of each dot predicted from its neighbours.
DotArray::Places DotArray::Adapted(const Image& image, const std::vector<int>& picks) const {
  Places now = image.places;
  std::vector<char> seen(size());
  for (std::size_t k = 0; k < size(); ++k) {
    seen[k] = picks[k] >= 0 ? 1 : 0;
    if (seen[k] != 0) now[k] = image.dots[Index(picks[k])].centre;
  }
  Places adapted;
  for (std::size_t k = 0; k < size(); ++k) adapted.push_back(Expect(k, image.places, now, seen));
  return adapted;
}

// Assigns to each place the nearest dot within the gate; if two places claim a dot, the nearer one
// gets it.
int DotArray::Assign(const Image& image, const Places& expected, std::vector<int>* picks) const {
  picks->assign(size(), kNoDot);
  std::vector<int> owners(image.dots.size(), kNoDot);
  int found = 0;
  for (std::size_t k = 0; k < size(); ++k) {
    double nearest = kGate * image.spacings[k];
    int pick = kNoDot;
    for (std::size_t i = 0; i < image.dots.size(); ++i) {
      const double distance = (image.dots[i].centre - expected[k]).norm();
      const bool alike = image.areas[k] <= 0 || Alike(image.dots[i].area, image.areas[k]);
      if (alike && distance < nearest) nearest = distance, pick = static_cast<int>(i);
    }
    if (pick == kNoDot) continue;
    int& owner = owners[Index(pick)];
    if (owner != kNoDot) {
      const Eigen::Vector2d& centre = image.dots[Index(pick)].centre;
      if ((expected[Index(owner)] - centre).norm() <= nearest) continue;
      (*picks)[Index(owner)] = kNoDot;
      --found;
    }
    owner = static_cast<int>(k);
    (*picks)[k] = pick;
    ++found;
  }
  return found;
}

Eigen::Vector2d DotArray::Expect(std::size_t k, std::span<const Eigen::Vector2d> before,
                                 std::span<const Eigen::Vector2d> now,
                                 std::span<const char> seen) const {
  AffineMotion motion(before[k]);
  for (const int j : neighbours_[k]) {
    const auto other = Index(j);
    if (seen[other] != 0) motion.Add(before[other], now[other]);
  }
  if (motion.count() >= 3) return motion.Now();
  motion = AffineMotion(before[k]);
  for (std::size_t j = 0; j < size(); ++j) {
    if (j != k && seen[j] != 0) motion.Add(before[j], now[j]);
  }
  return motion.Now();
}

double DotArray::Spacing(std::size_t k, std::span<const Eigen::Vector2d> places) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const int j : neighbours_[k]) {
    const double distance = (places[Index(j)] - places[k]).norm();
    if (distance < nearest) nearest = distance;  // false for values that are not finite
  }
  return std::isfinite(nearest) ? nearest : 0;
}

}  // namespace palpate
