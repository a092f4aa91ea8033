#include "slave/pipeline/load/triangle_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "shared/mesh/disc_patch.h"
#include "slave/checks/points/noise_limits.h"
#include "slave/mesh/index.h"
#include "slave/pipeline/load/volume_limits.h"
#include "slave/statistics/robust.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

bool IsSamePlace(const Vector3d& a, const Vector3d& b) {
  return (a - b).norm() <= VolumeLimits::kSamePlace * (a.norm() + b.norm());
}

}  // namespace

PointGreens::PointGreens(const SurfaceMesh& surface, double load, double patch)
    : surface_(surface), load_(load), index_(surface.nodes.size(), -1) {
  for (const auto& triangle : surface_.triangles) {
    for (const int node : triangle) {
      if (index_[Index(node)] >= 0) continue;
      index_[Index(node)] = static_cast<int>(nodes_.size());
      nodes_.push_back(node);
    }
  }
  FindPatches(patch);
}

// Distributes a load as the models do, so that the same load in the model gives equal
// displacements.
void PointGreens::FindPatches(double patch) {
  SurfaceFootprints footprints(surface_);
  for (const int node : nodes_) {
    const Contact load{
        .kind = Contact::Kind::kForce, .p_O = surface_.nodes[Index(node)], .width = patch};
    ContactFootprint footprint;
    const bool is_met = footprints.OnNodes(load, &footprint).empty();
    patches_.push_back(is_met ? std::move(footprint.places) : std::vector{PlaceWeight{node, 1}});
  }
}

void PointGreens::Update(DeformationModel& model, const SurfaceContact& contact,
                         const std::vector<SurfacePoint>& points_O) {
  if (rest_.size() != points_O.size()) {
    rest_.assign(points_O.size(), Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    known_.assign(points_O.size(), false);
    for (auto& by : by_) {
      by.setZero(3 * static_cast<Eigen::Index>(points_O.size()),
                 static_cast<Eigen::Index>(nodes_.size()));
    }
  }
  const double unknowns = 3 * static_cast<double>(std::max<std::size_t>(1, model.info().dof));
  double work = 0;
  int in_view = 0, missing = 0;
  for (const bool is_seen : {true, false}) {
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const Vector3d& p_O_rest = points_O[i].p_S_rest;
      if (points_O[i].seen != is_seen || !p_O_rest.allFinite()) continue;
      in_view += is_seen ? 1 : 0;
      if (IsSamePlace(rest_[i], p_O_rest)) continue;
      known_[i] = false;
      if (work > 0 && work + unknowns > VolumeLimits::kWork) {
        missing += is_seen ? 1 : 0;
        continue;
      }
      work += unknowns;
      rest_[i] = p_O_rest;
      Solve(model, contact, i);
    }
  }
  done_ = in_view > 0 ? 1 - static_cast<double>(missing) / in_view : 1;
}

void PointGreens::Solve(DeformationModel& model, const SurfaceContact& contact, std::size_t point) {
  const auto place = contact.Find(rest_[point], std::numeric_limits<double>::infinity());
  known_[point] = false;
  if (!place) return;
  Contact press{.kind = Contact::Kind::kForce, .p_O = place->p_O, .element = place->triangle};
  bool answered = true;
  for (int axis = 0; axis < 3 && answered; ++axis) {
    press.prescribed_O = load_ * Vector3d::Unit(axis);
    answered = Load(model, press, 3 * static_cast<Eigen::Index>(point) + axis);
  }
  known_[point] = answered;
}

void PointGreens::TakeOver(PointGreens* before, double scale, DeformationModel& model,
                           const SurfaceContact& contact) {
  const auto known = std::ranges::find(before->known_, true);
  if (known == before->known_.end()) return;
  const auto point = static_cast<std::size_t>(known - before->known_.begin());
  const auto row = 3 * static_cast<Eigen::Index>(point);
  by_.swap(before->by_);
  rest_.swap(before->rest_);
  known_.swap(before->known_);
  std::array<MatrixXd, 3> taken;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    by_[axis] *= scale;
    taken[axis] = by_[axis].middleRows(row, 3);
  }
  Solve(model, contact, point);
  double square = 0, difference = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    square += taken[axis].squaredNorm();
    difference += (by_[axis].middleRows(row, 3) - taken[axis]).squaredNorm();
  }
  const double accepted = VolumeLimits::kSameModel * VolumeLimits::kSameModel * square;
  if (known_[point] && difference <= accepted) return;
  rest_.clear();  // all are solved again
  known_.clear();
}

bool PointGreens::Load(DeformationModel& model, const Contact& contact, Eigen::Index row) {
  model.Reset();
  model.Solve({&contact, 1}, &solution_);
  if (solution_.responses().front().validity == Validity::kFailed) return false;
  model.Displacements(solution_, &field_);
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    Vector3d mean = Vector3d::Zero();
    for (const auto& [node, weight] : patches_[k]) mean += weight / load_ * field_[Index(node)];
    for (int axis = 0; axis < 3; ++axis)
      by_[Index(axis)](row, static_cast<Eigen::Index>(k)) = mean[axis];
  }
  return true;
}

TriangleSearch::TriangleSearch(const SurfaceMesh& surface, double load, double patch)
    : surface_(surface), greens_(surface, load, patch) {
  normals_.reserve(surface_.triangles.size());
  around_.resize(surface_.nodes.size());
  for (int t = 0; t < static_cast<int>(surface_.triangles.size()); ++t) {
    normals_.push_back(Normal(surface_, t));
    for (const int node : surface_.triangles[Index(t)]) around_[Index(node)].push_back(t);
  }
  node_normals_.resize(surface_.nodes.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < around_.size(); ++i) {
    for (const int t : around_[i]) node_normals_[i] += Area(surface_, t) * normals_[Index(t)];
    if (!around_[i].empty()) node_normals_[i].normalize();
  }
}

void TriangleSearch::Read(DeformationModel& model, const SurfaceContact& contact,
                          const std::vector<SurfacePoint>& points_O) {
  rest_.clear();
  for (const SurfacePoint& point : points_O) rest_.push_back(point.p_S_rest);
  greens_.Update(model, contact, points_O);
  seen_.assign(points_O.size(), {});
  usable_ = 0;
  for (std::size_t i = 0; i < points_O.size(); ++i) {
    const SurfacePoint& point = points_O[i];
    const Eigen::LLT<Matrix3d> factor(point.covariance);
    Seen& seen = seen_[i];
    seen.moved = point.p_S - point.p_S_rest;
    seen.whitener = factor.matrixL().solve(Matrix3d::Identity());
    seen.usable = seen.kept = point.seen && greens_.IsSolved(i) && seen.moved.allFinite() &&
                              factor.info() == Eigen::Success && seen.whitener.allFinite();
    usable_ += seen.usable ? 1 : 0;
  }
  kept_ = usable_;
  const auto rows = 3 * static_cast<Eigen::Index>(points_O.size());
  measured_.resize(rows);
  shape_.resize(rows);
  for (VectorXd& corner : corner_) corner.resize(rows);
  score_.resize(static_cast<Eigen::Index>(greens_.nodes().size()));
  sorted_.reserve(points_O.size());
}

TriangleLoad TriangleSearch::FindWithoutOutliers() noexcept {
  TriangleLoad best;
  for (int round = 0; round <= VolumeLimits::kRounds; ++round) {
    best = Find();
    if (best.triangle < 0 || round == VolumeLimits::kRounds || !ExcludeOutliers(best)) break;
  }
  return best;
}

// Searches the triangles around the last load and around the nodes whose normal load explains the
// most, then repeatedly those around the best triangle until none is better.
TriangleLoad TriangleSearch::Find() noexcept {
  Weigh();
  for (Eigen::Index k = 0; k < score_.size(); ++k) {
    const int node = greens_.nodes()[static_cast<std::size_t>(k)];
    ShapeOf(k, node_normals_[Index(node)], &shape_);
    const double mixed = shape_.dot(measured_), square = shape_.squaredNorm();
    score_[k] = square > 0 ? mixed * mixed / square : 0;
  }
  TriangleLoad best;
  if (last_ >= 0) SolveAroundTriangle(last_, &best);
  for (int n = 0; n < VolumeLimits::kBestNodes && n < score_.size(); ++n) {
    Eigen::Index k = 0;
    if (!(score_.maxCoeff(&k) >= 0)) break;
    score_[k] = -1;
    SolveAroundNode(greens_.nodes()[static_cast<std::size_t>(k)], &best);
  }
  for (int from = -1; best.triangle != from;) {
    from = best.triangle;
    SolveAroundTriangle(from, &best);
  }
  last_ = best.triangle;
  return best;
}

void TriangleSearch::SolveAroundTriangle(int triangle, TriangleLoad* best) noexcept {
  for (const int node : surface_.triangles[Index(triangle)]) SolveAroundNode(node, best);
}

void TriangleSearch::SolveAroundNode(int node, TriangleLoad* best) noexcept {
  for (const int t : around_[Index(node)]) {
    for (std::size_t c = 0; c < 3; ++c) {
      ShapeOf(greens_.IndexOf(surface_.triangles[Index(t)][c]), normals_[Index(t)], &corner_[c]);
    }
    SolveTriangle(t, best);
  }
}

void TriangleSearch::ShapeOf(Eigen::Index column, const Vector3d& n,
                             VectorXd* shape) const noexcept {
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(i);
    Vector3d u = Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      u += n[axis] * greens_.by(axis).col(column).segment<3>(row);
    }
    shape->segment<3>(row) = seen_[i].kept ? Vector3d(seen_[i].whitener * u) : Vector3d::Zero();
  }
}

void TriangleSearch::Weigh() noexcept {
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Seen& seen = seen_[i];
    measured_.segment<3>(3 * static_cast<Eigen::Index>(i)) =
        seen.kept ? Vector3d(seen.whitener * (seen.moved - seen.beyond)) : Vector3d::Zero();
  }
  square_ = measured_.squaredNorm();
}

// Solves for nodal forces of one sign by trying all subsets of nodes; the one that explains the
// most is used.
void TriangleSearch::SolveTriangle(int triangle, TriangleLoad* best) noexcept {
  for (unsigned choice = 1; choice < 8; ++choice) {
    Matrix3d normal = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (int a = 0; a < 3; ++a) {
      const bool takes_part = (choice >> a & 1U) != 0;
      normal(a, a) = takes_part ? corner_[Index(a)].squaredNorm() : 1;
      right[a] = takes_part ? corner_[Index(a)].dot(measured_) : 0;
      for (int b = 0; b < a; ++b) {
        if (!takes_part || (choice >> b & 1U) == 0) continue;
        normal(a, b) = normal(b, a) = corner_[Index(a)].dot(corner_[Index(b)]);
      }
    }
    const Eigen::LDLT<Matrix3d> factor(normal);
    const Vector3d forces = factor.solve(right);
    const bool one_sign = (forces.array() >= 0).all() || (forces.array() <= 0).all();
    const double explained = forces.dot(right);
    if (!forces.allFinite() || !one_sign || !(explained > best->explained)) continue;
    *best = {triangle, forces, factor.solve(Matrix3d::Identity()), explained};
    for (int a = 0; a < 3; ++a) {
      if ((choice >> a & 1U) == 0) best->covariance(a, a) = 0;
    }
  }
}

bool TriangleSearch::ExcludeOutliers(const TriangleLoad& best) noexcept {
  sorted_.clear();
  double worst = 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (!seen_[i].kept) continue;
    const Vector3d misfit = seen_[i].whitener * (seen_[i].moved - Displacement(best, i));
    seen_[i].residual = misfit.norm() / std::sqrt(3.0);
    worst = std::max(worst, seen_[i].residual);
    sorted_.push_back(seen_[i].residual);
  }
  const double accepted = std::max(
      NoiseLimits::kSignificant * std::max(NoiseLimits::kMinScatter, MedianOf(sorted_)), worst / 2);
  bool left_out = false;
  for (Seen& seen : seen_) {
    if (!seen.kept || seen.residual <= accepted || kept_ <= VolumeLimits::kMinPoints) continue;
    seen.kept = false;
    left_out = true;
    --kept_;
  }
  return left_out;
}

Vector3d TriangleSearch::Displacement(const TriangleLoad& best, std::size_t point) const noexcept {
  Vector3d u = Vector3d::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    const Eigen::Index column = greens_.IndexOf(surface_.triangles[Index(best.triangle)][c]);
    const Vector3d f = best.forces[static_cast<Eigen::Index>(c)] * normals_[Index(best.triangle)];
    for (int axis = 0; axis < 3; ++axis) {
      u += f[axis] * greens_.by(axis).col(column).segment<3>(3 * static_cast<Eigen::Index>(point));
    }
  }
  return u;
}

}  // namespace palpate
