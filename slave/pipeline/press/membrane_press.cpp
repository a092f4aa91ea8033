#include "slave/pipeline/press/membrane_press.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "shared/text/text.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

// Smallest number of points for an estimate [-]. [derived: three unknowns, and some to spare]
constexpr int kMinPoints = 10;

MembranePress::Params Checked(const MembranePress::Params& params) {
  if (!(params.patch > 0 && std::isfinite(params.patch))) {
    RefuseValue("patch", params.patch, "> 0 m");
  }
  if (!(params.model_error > 0 && std::isfinite(params.model_error))) {
    RefuseValue("model_error", params.model_error, "> 0 m");
  }
  return params;
}

std::vector<std::vector<int>> NeighboursOf(const SurfaceMesh& mesh) {
  std::vector<std::vector<int>> neighbours(mesh.nodes.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k];
      const int b = t[(k + 1) % 3];
      neighbours[Index(a)].push_back(b);
      neighbours[Index(b)].push_back(a);
    }
  }
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

// Returns half of the mean edge: the width of the patch's soft edge, which makes its shares
// continuous as it moves.
double EdgeSoftness(const SurfaceMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum += (mesh.nodes[Index(t[k])] - mesh.nodes[Index(t[(k + 1) % 3])]).norm();
    }
  }
  return sum / (6 * static_cast<double>(mesh.triangles.size()));
}

Eigen::Vector3d NormalAt(const InflatedMembrane& membrane, const SurfacePlace& place) {
  const auto& nodes = membrane.surface().triangles[Index(place.triangle)];
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    normal += place.weights[k] * membrane.normals()[Index(nodes[Index(k)])];
  }
  return normal.normalized();
}

// Least-squares paraboloid through the origin: a x + b y + c x^2 / 2 + d x y + e y^2 / 2.
class Paraboloid {
 public:
  struct Minimum {
    Eigen::Vector2d place;
    double min_curvature = 0;
  };
  void Add(double x, double y, double value) {
    const Vector5 row(x, y, x * x / 2, x * y, y * y / 2);
    normal_ += row * row.transpose();
    right_ += value * row;
    ++count_;
  }
  // nullopt: too few values, or no minimum.
  [[nodiscard]] std::optional<Minimum> Solve() const {
    if (count_ < 5) return std::nullopt;
    const Vector5 q = normal_.ldlt().solve(right_);
    const double determinant = q[2] * q[4] - q[3] * q[3], trace = q[2] + q[4];
    if (!(q.allFinite() && determinant > 1e-6 * trace * trace && trace > 0)) return std::nullopt;
    const Eigen::Vector2d place(q[3] * q[1] - q[4] * q[0], q[3] * q[0] - q[2] * q[1]);
    const double root = std::sqrt(std::max(0.0, trace * trace / 4 - determinant));
    return Minimum{place / determinant, trace / 2 - root};
  }

 private:
  using Vector5 = Eigen::Vector<double, 5>;
  Eigen::Matrix<double, 5, 5> normal_ = Eigen::Matrix<double, 5, 5>::Zero();
  Vector5 right_ = Vector5::Zero();
  int count_ = 0;
};

}  // namespace

MembranePress::MembranePress(InflatedMembrane membrane, const Params& params)
    : membrane_(std::move(membrane)),
      params_(Checked(params)),
      compliance_(membrane_, params.patch),
      neighbours_(NeighboursOf(membrane_.surface())),
      explained_(membrane_.surface().nodes.size()) {}

bool MembranePress::IsAttached(const std::vector<SurfacePoint>& points_O) const noexcept {
  if (points_O.size() != ids_.size()) return false;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (points_O[i].id != ids_[i] || points_O[i].p_S_rest != rest_[i]) return false;
  }
  return true;
}

void MembranePress::Attach(const std::vector<SurfacePoint>& points_O) {
  ids_.clear();
  rest_.clear();
  used_.clear();
  normals_.clear();
  std::vector<SurfacePlace> places;
  const SurfaceMesh& mesh = membrane_.surface();
  for (std::size_t i = 0; i < points_O.size(); ++i) {
    ids_.push_back(points_O[i].id);
    rest_.push_back(points_O[i].p_S_rest);
    const auto place = FindPlace(mesh, points_O[i].p_S_rest);
    if (!place || place->triangle < 0) continue;
    used_.push_back(i);
    normals_.push_back(NormalAt(membrane_, *place));
    places.push_back(*place);
  }
  const auto rows = static_cast<Eigen::Index>(places.size());
  g_ = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(mesh.nodes.size()));
  for (Eigen::Index i = 0; i < rows; ++i) {
    const SurfacePlace& place = places[static_cast<std::size_t>(i)];
    const auto& nodes = mesh.triangles[Index(place.triangle)];
    for (int k = 0; k < 3; ++k) {
      g_.row(i) += place.weights[k] * compliance_.by_patch().row(nodes[Index(k)]);
    }
  }
  y_ = w_ = g_here_ = Eigen::VectorXd::Zero(rows);
}

// Returns the number of usable points.
int MembranePress::Measure(const std::vector<SurfacePoint>& points_O) noexcept {
  int count = 0;
  for (std::size_t k = 0; k < used_.size(); ++k) {
    const SurfacePoint& point = points_O[used_[k]];
    const Eigen::Vector3d& n = normals_[k];
    const double deflection = n.dot(point.p_S - point.p_S_rest);
    const double variance = n.dot(point.covariance * n) + params_.model_error * params_.model_error;
    const bool usable =
        point.seen && std::isfinite(deflection) && variance > 0 && std::isfinite(variance);
    const auto i = static_cast<Eigen::Index>(k);
    y_[i] = usable ? deflection : 0;
    w_[i] = usable ? 1 / variance : 0;
    count += usable ? 1 : 0;
  }
  return count;
}

// Sum of squares that an inward force on this patch explains [sigma^2].
double MembranePress::Explained(const Eigen::Ref<const Eigen::VectorXd>& g) const noexcept {
  double gg = 0, gy = 0;
  for (Eigen::Index i = 0; i < y_.size(); ++i) {
    gg += w_[i] * g[i] * g[i];
    gy += w_[i] * g[i] * y_[i];
  }
  return gg > 0 && gy > 0 ? gy * gy / gg : 0;
}

int MembranePress::BestNode() noexcept {
  int best = -1;
  for (int node = 0; node < g_.cols(); ++node) {
    if (membrane_.IsHeld(node)) continue;
    explained_[Index(node)] = Explained(g_.col(node));
    if (best < 0 || explained_[Index(node)] > explained_[Index(best)]) best = node;
  }
  return best;
}

// Maximum of a paraboloid through the sums of squares at the node and its neighbours, limited to
// their distance; the sigma of the position follows from its curvature.
Eigen::Vector3d MembranePress::Interpolate(int node) noexcept {
  const auto at = Index(node);
  const auto& nodes = membrane_.surface().nodes;
  const Eigen::Vector3d e1 = membrane_.normals()[at].unitOrthogonal();
  const Eigen::Vector3d e2 = membrane_.normals()[at].cross(e1);
  double edge = 0;
  for (const int other : neighbours_[at]) {
    edge = std::max(edge, (nodes[Index(other)] - nodes[at]).norm());
  }
  estimate_.sigma_place = edge;
  Paraboloid fit;
  for (const int other : neighbours_[at]) {
    if (membrane_.IsHeld(other)) continue;
    const Eigen::Vector3d offset = (nodes[Index(other)] - nodes[at]) / edge;
    fit.Add(offset.dot(e1), offset.dot(e2), explained_[at] - explained_[Index(other)]);
  }
  const std::optional<Paraboloid::Minimum> minimum = fit.Solve();
  if (!minimum) return nodes[at];
  const Eigen::Vector2d step = minimum->place / std::max(1.0, minimum->place.norm());
  // The explained sum of squares decreases by one at a distance of one sigma.
  estimate_.sigma_place = edge * std::sqrt(2 / minimum->min_curvature);
  return nodes[at] + edge * (step[0] * e1 + step[1] * e2);
}

void MembranePress::FillEstimate(int points) noexcept {
  const auto& nodes = membrane_.surface().triangles[Index(place_.triangle)];
  g_here_.setZero();
  estimate_.p_O.setZero();
  for (int k = 0; k < 3; ++k) {
    const int node = nodes[Index(k)];
    g_here_ += place_.weights[k] * g_.col(node);
    estimate_.p_O += place_.weights[k] * membrane_.surface().nodes[Index(node)];
  }
  estimate_.n_O = NormalAt(membrane_, place_);
  const double gg = g_here_.cwiseAbs2().dot(w_);
  if (!(gg > 0)) return;
  estimate_.force = g_here_.cwiseProduct(w_).dot(y_) / gg;
  const double inward = std::max(0.0, estimate_.force);
  const double squares = (y_ - inward * g_here_).cwiseAbs2().dot(w_);
  estimate_.sigma = std::sqrt(points / w_.sum());
  estimate_.residual = std::sqrt(squares / points);
  const double scatter = std::max(1.0, estimate_.residual);
  estimate_.sigma_force = scatter / std::sqrt(gg);
  estimate_.sigma_place *= scatter;
  estimate_.depth = inward * compliance_.At(nodes, place_.weights);
  estimate_.found = true;
}

const MembranePress::Estimate& MembranePress::Fit(
    const std::vector<SurfacePoint>& points_O) noexcept {
  estimate_ = {};
  try {
    if (!IsAttached(points_O)) Attach(points_O);
  } catch (const std::exception&) {
    ids_.clear();
    used_.clear();
    return estimate_;
  }
  const int points = Measure(points_O);
  if (points < kMinPoints) return estimate_;
  const int node = BestNode();
  if (node < 0) return estimate_;
  const auto place = FindPlace(membrane_.surface(), Interpolate(node));
  if (!place || place->triangle < 0) return estimate_;
  place_ = *place;
  FillEstimate(points);
  return estimate_;
}

PatchCompliance::PatchCompliance(const InflatedMembrane& membrane, double diameter) {
  const SurfaceMesh& mesh = membrane.surface();
  const auto nodes = static_cast<Eigen::Index>(mesh.nodes.size());
  const Eigen::MatrixXd compliance = membrane.NormalCompliance();
  shares_.resize(mesh.nodes.size());
  by_patch_ = Eigen::MatrixXd::Zero(nodes, nodes);
  const double softness = EdgeSoftness(mesh);
  for (int j = 0; j < static_cast<int>(nodes); ++j) {
    if (membrane.IsHeld(j)) continue;
    const auto at = Index(j);
    std::vector<Share>& shares = shares_[at];
    // Pressures act along each node's normal, so the force is the sum of their components along the
    // patch's normal.
    double sum = 0;
    for (int i = 0; i < static_cast<int>(nodes); ++i) {
      const auto node = Index(i);
      const double r = (mesh.nodes[node] - mesh.nodes[at]).norm();
      const double inside = std::clamp(0.5 + (diameter / 2 - r) / (2 * softness), 0.0, 1.0);
      const double facing = membrane.normals()[node].dot(membrane.normals()[at]);
      if (i != j && (inside == 0 || facing <= 0)) continue;
      const double push = std::max(inside, i == j ? 1e-3 : 0) * membrane.areas()[node];
      shares.push_back({i, push});
      sum += push * facing;
    }
    for (Share& share : shares) {
      share.share /= sum;
      by_patch_.col(j) -= share.share * compliance.col(share.node);
    }
  }
}

double PatchCompliance::At(const std::array<int, 3>& triangle,
                           const Eigen::Vector3d& weights) const noexcept {
  double compliance = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const double weight = weights[static_cast<int>(a)] * weights[static_cast<int>(b)];
      for (const Share& share : shares(triangle[b])) {
        compliance -= weight * share.share * by_patch_(share.node, triangle[a]);
      }
    }
  }
  return compliance;
}

}  // namespace palpate
