#include <algorithm>
#include <cmath>
#include <optional>

#include "slave/statistics/robust.h"
#include "slave/vision/edge_profile.h"
#include "slave/vision/rest_contour.h"

namespace palpate {
namespace {

// Error of the centroid [px]. [tuned: BlurredStraightEdgesAreFoundToATwentiethOfAPixel]
constexpr double kHalfEdgeWindow = 3;
constexpr double kMinEdgeStep = 3;  // total step across a clear edge [1/255 of full scale]
// Cosine between the normals before and after a point. [-] [tuned:
// BothPolaritiesAndADeepImageGiveTheSameEdge]
constexpr double kStraightEdge = 0.97;
constexpr std::size_t kNeighbours = 4;  // neighbours on either side used to detect jumps
// Smallest jump: in pixels, and relative to the median change.
constexpr double kMinJump = 1, kJump = 4;
// Smallest contrast of a used point relative to the median edge.
constexpr double kMinContrast = 0.35;

struct Edge {
  double place = 0;  // along the normal [px]
  double step = 0;   // step of the grey level across the edge [1/255 of full scale]
};

std::optional<Edge> FindEdge(const EdgeProfile& profile, double sign, int reach) {
  int at = 0;
  double steepest = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double step = sign * profile.StepAt(k);
    if (step > steepest) steepest = step, at = k;
  }
  if (steepest <= 0) return std::nullopt;
  const double place = profile.Centroid(sign, at, kHalfEdgeWindow);
  if (std::abs(place) > reach + 1) return std::nullopt;
  return Edge{place, steepest / profile.format().levels_per_255()};
}

struct Ray {
  Eigen::Vector2d p, n;  // the normal points outwards everywhere, or inwards everywhere
  std::optional<Edge> rising, falling;
};

std::vector<Ray> RaysAcross(const cv::Mat& image, const GreyFormat& format, const Curve& even,
                            int reach) {
  const int half = reach + EdgeProfile::kMargin;
  EdgeProfile profile(format, half);
  const std::size_t n = even.size();
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d in = (even[i] - even[(i + n - 1) % n]).normalized();
    const Eigen::Vector2d out = (even[(i + 1) % n] - even[i]).normalized();
    if (in.dot(out) < kStraightEdge) continue;
    const Eigen::Vector2d t = (in + out).normalized();
    const Eigen::Vector2d normal(t.y(), -t.x());
    if (!profile.Read(image, even[i], normal, half)) continue;
    rays.push_back({even[i], normal, FindEdge(profile, 1, reach), FindEdge(profile, -1, reach)});
  }
  return rays;
}

// Returns whether most steps across the contour rise.
bool Rises(const std::vector<Ray>& rays) {
  int balance = 0;
  for (const Ray& ray : rays) {
    const double up = ray.rising ? ray.rising->step : 0;
    const double down = ray.falling ? ray.falling->step : 0;
    balance += up > down ? 1 : -1;
  }
  return balance >= 0;
}

// Drops positions that jump from their neighbours by more than usual, because they are on another
// edge.
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
  const double largest = std::max(kMinJump, kJump * MedianOf(found));
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
  const std::vector<Ray> rays = RaysAcross(image, format, Resample(contour, count), options.reach);
  const bool rises = Rises(rays);

  std::vector<std::optional<Edge>> edges;
  std::vector<double> steps;
  for (const Ray& ray : rays) {
    edges.push_back(rises ? ray.rising : ray.falling);
    if (edges.back()) steps.push_back(edges.back()->step);
  }
  if (steps.empty()) return {};
  const double least = std::max(kMinEdgeStep, kMinContrast * MedianOf(steps));

  DropJumps(edges);
  Curve refined;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    if (edges[k] && edges[k]->step >= least)
      refined.push_back(rays[k].p + edges[k]->place * rays[k].n);
  }
  return refined;
}

}  // namespace palpate
