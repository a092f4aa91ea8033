#include "slave/pipeline/press/membrane_press.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

// Points of a reading [-]. [derived: position, force, pressure, and some to spare]
constexpr int kLeastPoints = 10;

MembranePress::Params Checked(const MembranePress::Params& params) {
  const auto number = [](const std::string& name, double value, bool accepted,
                         const std::string& what) {
    if (!accepted) {
      throw std::invalid_argument(name + " = " + std::to_string(value) + ": accepted is " + what);
    }
  };
  number("patch", params.patch, params.patch >= 0 && std::isfinite(params.patch), ">= 0 m");
  number("model_error", params.model_error,
         params.model_error > 0 && std::isfinite(params.model_error), "> 0 m");
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

// Half the mean edge: how softly a patch ends, so that it changes steadily as it moves.
double EdgeSoftness(const SurfaceMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum += (mesh.nodes[Index(t[k])] - mesh.nodes[Index(t[(k + 1) % 3])]).norm();
    }
  }
  return sum / (6 * static_cast<double>(mesh.triangles.size()));
}

}  // namespace

MembranePress::MembranePress(InflatedMembrane membrane, const Params& params)
    : membrane_(std::move(membrane)),
      params_(Checked(params)),
      compliance_(membrane_, params.patch, params.pressure_is_measured),
      neighbours_(NeighboursOf(membrane_.surface())),
      misfits_(membrane_.surface().nodes.size()) {}

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
  taking_part_.clear();
  normals_.clear();
  std::vector<SurfacePlace> places;
  const SurfaceMesh& mesh = membrane_.surface();
  for (std::size_t i = 0; i < points_O.size(); ++i) {
    ids_.push_back(points_O[i].id);
    rest_.push_back(points_O[i].p_S_rest);
    const auto place = FindPlace(mesh, points_O[i].p_S_rest);
    if (!place || place->triangle < 0) continue;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    const auto& nodes = mesh.triangles[Index(place->triangle)];
    for (int k = 0; k < 3; ++k) {
      normal += place->weights[k] *
                membrane_.normals()[static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)])];
    }
    taking_part_.push_back(i);
    normals_.push_back(normal.normalized());
    places.push_back(*place);
  }
  const auto rows = static_cast<Eigen::Index>(places.size());
  g_ = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(mesh.nodes.size()));
  b_ = Eigen::VectorXd::Zero(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const SurfacePlace& place = places[static_cast<std::size_t>(i)];
    const auto& nodes = mesh.triangles[Index(place.triangle)];
    for (int k = 0; k < 3; ++k) {
      const int node = nodes[Index(k)];
      g_.row(i) += place.weights[k] * compliance_.by_patch().row(node);
      if (params_.pressure_is_measured) b_[i] += place.weights[k] * compliance_.by_pressure()[node];
    }
  }
  y_ = w_ = g_here_ = Eigen::VectorXd::Zero(rows);
}

int MembranePress::Measure(const std::vector<SurfacePoint>& points_O) noexcept {
  int taking_part = 0;
  yy_ = yb_ = bb_ = 0;
  for (std::size_t k = 0; k < taking_part_.size(); ++k) {
    const SurfacePoint& point = points_O[taking_part_[k]];
    const Eigen::Vector3d& n = normals_[k];
    const double way = n.dot(point.p_S - point.p_S_rest);
    const double variance = n.dot(point.covariance * n) + params_.model_error * params_.model_error;
    const bool usable = point.seen && std::isfinite(way) && variance > 0 && std::isfinite(variance);
    const auto i = static_cast<Eigen::Index>(k);
    y_[i] = usable ? way : 0;
    w_[i] = usable ? 1 / variance : 0;
    yy_ += w_[i] * y_[i] * y_[i];
    yb_ += w_[i] * y_[i] * b_[i];
    bb_ += w_[i] * b_[i] * b_[i];
    taking_part += usable ? 1 : 0;
  }
  return taking_part;
}

MembranePress::Sums MembranePress::SumsOf(
    const Eigen::Ref<const Eigen::VectorXd>& g) const noexcept {
  Sums sums;
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    const double wg = w_[i] * g[i];
    sums.gg += wg * g[i];
    sums.gy += wg * y_[i];
    sums.gb += wg * b_[i];
  }
  return sums;
}

MembranePress::Amplitudes MembranePress::Explaining(const Sums& s) const noexcept {
  Amplitudes best;  // by the pressure alone, or nothing
  if (bb_ > 0) best.pressure = yb_ / bb_;
  best.misfit = yy_ - best.pressure * yb_;
  if (!(s.gg > 0)) return best;
  Amplitudes both;
  const double determinant = s.gg * bb_ - s.gb * s.gb;
  if (determinant > 1e-9 * s.gg * bb_) {
    both.force = (s.gy * bb_ - yb_ * s.gb) / determinant;
    both.pressure = (yb_ * s.gg - s.gy * s.gb) / determinant;
  } else {
    both.force = s.gy / s.gg;
  }
  both.misfit = yy_ - both.force * s.gy - both.pressure * yb_;
  return both.force > 0 && both.misfit < best.misfit ? both : best;
}

int MembranePress::BestNode() noexcept {
  int best = -1;
  for (Eigen::Index j = 0; j < g_.cols(); ++j) {
    const auto node = static_cast<std::size_t>(j);
    misfits_[node] = std::numeric_limits<double>::infinity();
    if (membrane_.IsHeld(static_cast<int>(j))) continue;
    misfits_[node] = Explaining(SumsOf(g_.col(j))).misfit;
    if (best < 0 || misfits_[node] < misfits_[Index(best)]) {
      best = static_cast<int>(j);
    }
  }
  return best;
}

// Where a paraboloid through the misfits of the node and its neighbours is lowest, no farther than
// they are; its curvature gives the place's sigma.
Eigen::Vector3d MembranePress::Between(int node) noexcept {
  const auto at = Index(node);
  const auto& nodes = membrane_.surface().nodes;
  const Eigen::Vector3d e1 = membrane_.normals()[at].unitOrthogonal();
  const Eigen::Vector3d e2 = membrane_.normals()[at].cross(e1);
  double edge = 0;
  for (const int other : neighbours_[at]) {
    edge = std::max(edge, (nodes[Index(other)] - nodes[at]).norm());
  }
  Eigen::Matrix<double, 5, 5> normal_matrix = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
  reading_.sigma_place = edge;
  int count = 0;
  for (const int other : neighbours_[at]) {
    const auto to = Index(other);
    if (!std::isfinite(misfits_[to])) continue;
    const Eigen::Vector3d way = (nodes[to] - nodes[at]) / edge;
    const double x = way.dot(e1);
    const double y = way.dot(e2);
    Eigen::Matrix<double, 5, 1> row;
    row << x, y, x * x / 2, x * y, y * y / 2;
    normal_matrix += row * row.transpose();
    right += row * (misfits_[to] - misfits_[at]);
    ++count;
  }
  if (count < 5) return nodes[at];
  const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> ldlt(normal_matrix);
  const Eigen::Matrix<double, 5, 1> q = ldlt.solve(right);
  const double determinant = q[2] * q[4] - q[3] * q[3];
  const double trace = q[2] + q[4];
  if (!(q.allFinite() && determinant > 1e-6 * trace * trace && trace > 0)) return nodes[at];
  Eigen::Vector2d step(-(q[4] * q[0] - q[3] * q[1]) / determinant,
                       -(q[2] * q[1] - q[3] * q[0]) / determinant);
  if (step.norm() > 1) step.normalize();
  // Misfit is a sum of squares in sigmas: it rises by one at a distance of one sigma.
  const double flattest = trace / 2 - std::sqrt(std::max(0.0, trace * trace / 4 - determinant));
  reading_.sigma_place = edge * std::sqrt(2 / flattest);
  return nodes[at] + edge * (step[0] * e1 + step[1] * e2);
}

void MembranePress::ReadAt() noexcept {
  const auto& nodes = membrane_.surface().triangles[Index(place_.triangle)];
  g_here_.setZero();
  reading_.p_O.setZero();
  reading_.n_O.setZero();
  for (int k = 0; k < 3; ++k) {
    const int node = nodes[Index(k)];
    g_here_ += place_.weights[k] * g_.col(node);
    reading_.p_O += place_.weights[k] * membrane_.surface().nodes[Index(node)];
    reading_.n_O += place_.weights[k] * membrane_.normals()[Index(node)];
  }
  reading_.n_O.normalize();
  const Sums sums = SumsOf(g_here_);
  if (!(sums.gg > 0)) return;
  const Amplitudes both = Explaining(sums);
  reading_.own_force = sums.gy / sums.gg;
  reading_.air_area = -sums.gb / sums.gg;
  reading_.explained_force = both.force;
  reading_.own_pressure = both.pressure;
  const double sum_of_weights = w_.sum();
  reading_.deflection = std::sqrt(yy_ / sum_of_weights);
  reading_.residual = std::sqrt(std::max(0.0, both.misfit) / sum_of_weights);
  reading_.relative_residual = std::sqrt(std::max(0.0, both.misfit) / reading_.points);
  // What the model does not explain counts as error too.
  const double scatter = std::max(1.0, reading_.relative_residual);
  reading_.sigma_own_force = scatter / std::sqrt(sums.gg);
  reading_.sigma_place *= scatter;
  double by_pressure = 0;
  for (int k = 0; k < 3 && params_.pressure_is_measured; ++k) {
    by_pressure += place_.weights[k] * compliance_.by_pressure()[nodes[Index(k)]];
  }
  reading_.depth =
      both.force * compliance_.GiveAt(nodes, place_.weights) - both.pressure * by_pressure;
  reading_.found = true;
}

const MembranePress::Reading& MembranePress::Fit(
    const std::vector<SurfacePoint>& points_O) noexcept {
  reading_ = Reading{};
  try {
    if (!IsAttached(points_O)) Attach(points_O);
  } catch (const std::exception&) {
    ids_.clear();
    taking_part_.clear();
    return reading_;
  }
  reading_.points = Measure(points_O);
  if (reading_.points < kLeastPoints) return reading_;
  const int node = BestNode();
  if (node < 0) return reading_;
  const auto place = FindPlace(membrane_.surface(), Between(node));
  if (!place || place->triangle < 0) return reading_;
  place_ = *place;
  ReadAt();
  return reading_;
}

PatchCompliance::PatchCompliance(const InflatedMembrane& membrane, double diameter,
                                 bool steady_air) {
  const SurfaceMesh& mesh = membrane.surface();
  const auto nodes = static_cast<Eigen::Index>(mesh.nodes.size());
  const Eigen::MatrixXd compliance = membrane.NormalCompliance(steady_air);
  by_pressure_ = compliance * Eigen::Map<const Eigen::VectorXd>(membrane.areas().data(), nodes);
  shares_.resize(mesh.nodes.size());
  by_patch_ = Eigen::MatrixXd::Zero(nodes, nodes);
  const double softness = EdgeSoftness(mesh);
  for (int j = 0; j < static_cast<int>(nodes); ++j) {
    if (membrane.IsHeld(j)) continue;
    const auto at = Index(j);
    std::vector<Share>& shares = shares_[at];
    // Pressures act along each node's own normal: what counts is their sum along the patch's.
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

double PatchCompliance::GiveAt(const std::array<int, 3>& triangle,
                               const Eigen::Vector3d& weights) const noexcept {
  double give = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const double weight = weights[static_cast<int>(a)] * weights[static_cast<int>(b)];
      for (const Share& share : shares(triangle[b])) {
        give -= weight * share.share * by_patch_(share.node, triangle[a]);
      }
    }
  }
  return give;
}

}  // namespace palpate
