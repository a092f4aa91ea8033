#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/statistics/robust.h"
#include "slave/vision/rest_contour.h"

namespace palpate {
namespace {

// The profile is the mean of 2 kAside + 1 lines, 1 px apart. [-] [tuned:
// BothPolaritiesAndADeepPictureGiveTheSameEdge]
constexpr int kAside = 2;
constexpr double kStep = 0.5;  // between samples of a profile [px]
// Of the centroid [px]. [tuned: BothPolaritiesAndADeepPictureGiveTheSameEdge]
constexpr double kHalfWindow = 3;
constexpr int kCentrings = 12;
constexpr double kLeastEdge = 3;  // total step across a clear edge [1/255 of full scale]
// Cosine between the normals before and after a point. [-] [tuned:
// BothPolaritiesAndADeepPictureGiveTheSameEdge]
constexpr double kStraight = 0.97;
constexpr std::size_t kNeighbours = 4;       // to either side, that tell whether an edge jumps
constexpr double kLeastJump = 1, kJump = 4;  // what counts as one: [px], of the median jump
constexpr double kLeastContrast = 0.35;      // of the median edge, below which a point is left out

struct Profile {
  std::vector<double> slope;  // d level / d s, kStep apart
  double first = 0;           // place of slope[0] along the normal [px]
};

class Refiner {
 public:
  Refiner(const cv::Mat& image, const GreyFormat& format, double reach) : reach_(reach) {
    format.Read(image, cv::Rect(cv::Point(), image.size()), grey_);
    unit_ = 1 / format.levels_per_255();
  }

  // Slopes along the unit normal `n` through `p`; none where it leaves the picture.
  [[nodiscard]] std::optional<Profile> Along(const Eigen::Vector2d& p,
                                             const Eigen::Vector2d& n) const {
    const Eigen::Vector2d t(-n.y(), n.x());
    const int half = static_cast<int>((reach_ + kHalfWindow + 1) / kStep);
    std::vector<double> level;
    for (int k = -half; k <= half; ++k) {
      double sum = 0;
      for (int j = -kAside; j <= kAside; ++j) {
        const auto sample = Level(p + (k * kStep) * n + static_cast<double>(j) * t);
        if (!sample) return std::nullopt;
        sum += *sample;
      }
      level.push_back(sum / (2 * kAside + 1));
    }
    Profile profile;
    profile.first = (-half + 0.5) * kStep;
    for (std::size_t k = 1; k < level.size(); ++k) {
      profile.slope.push_back((level[k] - level[k - 1]) / kStep);
    }
    return profile;
  }

 private:
  [[nodiscard]] std::optional<double> Level(const Eigen::Vector2d& p) const {
    const bool inside =
        p.x() >= 0 && p.y() >= 0 && p.x() < grey_.width - 1 && p.y() < grey_.height - 1;
    if (!inside) return std::nullopt;
    const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
    const double u = p.x() - x, v = p.y() - y;
    return unit_ * ((1 - v) * ((1 - u) * grey_.At(x, y) + u * grey_.At(x + 1, y)) +
                    v * ((1 - u) * grey_.At(x, y + 1) + u * grey_.At(x + 1, y + 1)));
  }

  GreyPatch grey_;
  double unit_ = 1;
  double reach_;
};

struct Edge {
  double place = 0;  // along the normal [px]
  double step = 0;   // of grey level across it
};

// Sum of slopes and their moment within the window around `centre`; its ends are weighted by the
// part of a sample that lies inside.
Edge Centroid(const Profile& profile, double polarity, double centre) {
  double sum = 0, moment = 0;
  for (std::size_t k = 0; k < profile.slope.size(); ++k) {
    const double s = profile.first + static_cast<double>(k) * kStep;
    const double inside = std::clamp((kHalfWindow - std::abs(s - centre)) / kStep + 0.5, 0.0, 1.0);
    sum += inside * polarity * profile.slope[k];
    moment += inside * polarity * profile.slope[k] * (s - centre);
  }
  return {sum > 0 ? centre + moment / sum : centre, sum * kStep};
}

std::optional<Edge> FindEdge(const Profile& profile, double polarity, double reach) {
  double place = 0, steepest = 0;
  for (std::size_t k = 1; k + 1 < profile.slope.size(); ++k) {
    const double s = profile.first + static_cast<double>(k) * kStep;
    const double slope =
        polarity * (profile.slope[k - 1] + 2 * profile.slope[k] + profile.slope[k + 1]);
    if (std::abs(s) > reach || slope <= steepest) continue;
    steepest = slope;
    place = s;
  }
  if (steepest <= 0) return std::nullopt;
  Edge edge;
  for (int k = 0; k < kCentrings; ++k) {
    edge = Centroid(profile, polarity, place);
    const bool settled = std::abs(edge.place - place) < 1e-4;
    place = edge.place;
    if (std::abs(place) > reach + 1) return std::nullopt;
    if (settled) break;
  }
  return edge;
}

struct Ray {
  Eigen::Vector2d p, n;  // outward or inward, but the same side all round
  Profile profile;
};

std::vector<Ray> RaysAcross(const Refiner& refiner, const Curve& even) {
  const std::size_t n = even.size();
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d in = (even[i] - even[(i + n - 1) % n]).normalized();
    const Eigen::Vector2d out = (even[(i + 1) % n] - even[i]).normalized();
    if (in.dot(out) < kStraight) continue;
    const Eigen::Vector2d t = (in + out).normalized();
    const Eigen::Vector2d normal(t.y(), -t.x());
    if (auto profile = refiner.Along(even[i], normal)) {
      rays.push_back({even[i], normal, std::move(*profile)});
    }
  }
  return rays;
}

// +1 or -1: the sign of most of the contour's steps.
double Polarity(const std::vector<Ray>& rays, double reach) {
  int balance = 0;
  for (const Ray& ray : rays) {
    const auto up = FindEdge(ray.profile, 1, reach), down = FindEdge(ray.profile, -1, reach);
    balance += (up ? up->step : 0) > (down ? down->step : 0) ? 1 : -1;
  }
  return balance >= 0 ? 1 : -1;
}

// Where the edge jumps away from those around it, farther than edges here do as a rule, another
// edge was taken for it.
void DropJumps(std::vector<std::optional<Edge>>& edges) {
  const std::size_t n = edges.size();
  if (n <= 2 * kNeighbours) return;
  std::vector<double> jumps(n, 0), found;
  for (std::size_t k = 0; k < n; ++k) {
    if (!edges[k]) continue;
    std::vector<double> around;
    for (std::size_t j = n + k - kNeighbours; j <= n + k + kNeighbours; ++j) {
      if (edges[j % n]) around.push_back(edges[j % n]->place);
    }
    jumps[k] = std::abs(edges[k]->place - MedianOf(around));
    found.push_back(jumps[k]);
  }
  if (found.empty()) return;
  const double largest = std::max(kLeastJump, kJump * MedianOf(found));
  for (std::size_t k = 0; k < n; ++k) {
    if (jumps[k] > largest) edges[k].reset();
  }
}

}  // namespace

Curve RefineContour(const cv::Mat& image, const GreyFormat& format, CurveView contour,
                    const RefinementOptions& options) {
  const double length = CurveLength(contour);
  if (!(length > 0)) return {};
  const int count = std::max(8, static_cast<int>(length / options.spacing));
  const Refiner refiner(image, format, options.reach);
  const std::vector<Ray> rays = RaysAcross(refiner, Resample(contour, count));
  const double polarity = Polarity(rays, options.reach);

  std::vector<std::optional<Edge>> edges;
  std::vector<double> steps;
  for (const Ray& ray : rays) {
    edges.push_back(FindEdge(ray.profile, polarity, options.reach));
    if (edges.back()) steps.push_back(edges.back()->step);
  }
  if (steps.empty()) return {};
  const double least = std::max(kLeastEdge, kLeastContrast * MedianOf(steps));

  DropJumps(edges);
  Curve refined;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    if (edges[k] && edges[k]->step >= least)
      refined.push_back(rays[k].p + edges[k]->place * rays[k].n);
  }
  return refined;
}

}  // namespace palpate
