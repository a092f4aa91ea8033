#include "slave/mechanics/bem3d/reference_system.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/geometry/index.h"
#include "shared/geometry/symmetric_eigen.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Motions = Eigen::Matrix<double, 6, 6>;

constexpr double kHeldMotion = 1e-9;  // mean square of a rigid motion at what is held: it is free

double Checked(double nu) {
  if (nu > -1 && nu <= 0.5) return nu;
  RefuseValue("poisson_ratio", nu, "-1 < nu <= 0.5");
}

}  // namespace

ReferenceSystem::ReferenceSystem(const SurfaceMesh& mesh, HeldNodes held, double nu)
    : surface_(mesh),
      fit_(mesh, surface_),
      held_(std::move(held)),
      nu_(Checked(nu)),
      constants_(nu) {
  if (held_.size() != surface_.elements.size()) {
    throw std::invalid_argument("boundary conditions for " + std::to_string(held_.size()) + " of " +
                                std::to_string(triangles()) + " triangles");
  }
  RequireCompressible();
  MarkHeldNodes();
  FindFreeMotions();
}

void ReferenceSystem::RequireCompressible() const {
  const auto refuse = [&](double largest, const std::string& accepted) {
    if (nu_ <= largest) return;
    RefuseValue("poisson_ratio", nu_,
                accepted + " (the boundary integrals do not determine the pressure near 0.5)");
  };
  if (surface_.has_cavities) {
    refuse(kLargestNuWithCavities, "at most 0.45 for a body with cavities");
  }
  const bool all_held =
      std::ranges::all_of(held_, [](const auto& h) { return h[0] && h[1] && h[2]; });
  if (all_held) refuse(kLargestNuAllHeld, "at most 0.499 for a body whose whole surface is fixed");
}

Eigen::Matrix<double, 3, 6> ReferenceSystem::RigidModes(const Vector3d& p) const {
  const Vector3d r = p - mean_;
  Eigen::Matrix<double, 3, 6> modes;
  modes << 1, 0, 0, 0, r.z(), -r.y(),  //
      0, 1, 0, -r.z(), 0, r.x(),       //
      0, 0, 1, r.y(), -r.x(), 0;
  return modes * motions_;
}

// Rigid motions are u = c + w x (p - p_mean). Those that vanish at all held components remain.
void ReferenceSystem::FindFreeMotions() {
  double total = 0;
  for (const auto& t : surface_.elements) {
    mean_ += t.area * t.centroid;
    total += t.area;
  }
  mean_ /= total;
  Motions gram = Motions::Zero();
  double held_area = 0;
  for (int i = 0; i < triangles(); ++i) {
    const auto& t = surface_.elements[Index(i)];
    for (int c = 0; c < 3; ++c) {
      if (!held(i, c)) continue;
      const Eigen::Matrix<double, 1, 6> moved = RigidModes(t.centroid).row(c);
      gram += t.area * moved.transpose() * moved;
      held_area += t.area;
    }
  }
  if (held_area > 0) {
    const SymmetricEigen eigen = EigenOf(gram / held_area);
    free_motions_ = static_cast<int>((eigen.values.array() < kHeldMotion).count());
    motions_ = eigen.vectors;  // ascending: the free ones first
  }
  motions_.rightCols(6 - free_motions_).setZero();
}

void ReferenceSystem::MarkHeldNodes() {
  held_nodes_.resize(Index(fit_.nodes()));
  for (int i = 0; i < triangles(); ++i) {
    for (const int node : fit_.corners(i)) {
      for (std::size_t c = 0; c < 3; ++c) {
        if (held(i, static_cast<int>(c))) held_nodes_[Index(node)][c] = true;
      }
    }
  }
}

KelvinSolidBlocks ReferenceSystem::Blocks(int i, int j) const {
  const auto& source = surface_.elements[Index(j)];
  if (i == j) {
    KelvinSolidBlocks blocks = IntegrateKelvinOnItself(constants_, source);
    blocks.of_displacement.diagonal().array() += 0.5;
    return blocks;
  }
  return IntegrateKelvin(constants_, source, surface_.elements[Index(i)].centroid);
}

MatrixXd ReferenceSystem::Matrix(const std::function<void(int)>& before) const {
  MatrixXd A(order(), order());
  for (int begin = 0; begin < triangles(); begin += kRows) {
    before(begin);
    const int end = std::min(begin + kRows, triangles());
    A.middleRows(3 * begin, 3 * (end - begin)) = Rows(begin, end);
  }
  if (free_motions_ > 0) A.bottomRows(6) = MeanMotions();
  return A;
}

MatrixXd ReferenceSystem::Rows(int begin, int end) const {
  MatrixXd rows = MatrixXd::Zero(3 * Eigen::Index{end - begin}, order());
  MatrixXd by_node = MatrixXd::Zero(rows.rows(), 3 * Eigen::Index{fit_.nodes()});
  FillRows(begin, end, &rows, &by_node);
  ShareNodes(by_node, &rows);
  return rows;
}

// What belongs to triangles goes to `rows`, what belongs to the displacements at their corners to
// `by_node`.
void ReferenceSystem::FillRows(int begin, int end, MatrixXd* rows, MatrixXd* by_node) const {
  const Eigen::Index n = 3 * Eigen::Index{triangles()};
  for (int j = 0; j < triangles(); ++j) {
    const auto modes = RigidModes(surface_.elements[Index(j)].centroid);
    for (int i = begin; i < end; ++i) {
      const KelvinSolidBlocks blocks = Blocks(i, j);
      const int row = 3 * (i - begin);
      for (int c = 0; c < 3; ++c) {
        if (held(j, c)) {
          rows->block<3, 1>(row, 3 * j + c) = -blocks.of_traction.col(c);
        } else {
          rows->block<3, 1>(row, 3 * j + c) = blocks.of_displacement.col(c);
        }
      }
      for (std::size_t k = 0; k < 3; ++k) {
        by_node->block<3, 3>(row, 3 * fit_.corners(j)[k]) += blocks.of_corner[k];
      }
      if (free_motions_ > 0) rows->block<3, 6>(row, n) -= blocks.of_traction * modes;
    }
  }
}

// Held nodes stand still, all others move with the triangles around them.
void ReferenceSystem::ShareNodes(const MatrixXd& by_node, MatrixXd* rows) const {
  for (int node = 0; node < fit_.nodes(); ++node) {
    for (int c = 0; c < 3; ++c) {
      if (held_nodes_[Index(node)][Index(c)]) continue;
      for (const auto& [triangle, weight] : fit_.shares(node)) {
        if (held(triangle, c)) continue;
        rows->col(3 * triangle + c) += weight * by_node.col(3 * node + c);
      }
    }
  }
}

// H u - G m b = G t with the balancing tractions m b; the mean of m . u is zero.
MatrixXd ReferenceSystem::MeanMotions() const {
  MatrixXd rows = MatrixXd::Zero(6, order());
  rows.rightCols(6).diagonal().tail(6 - free_motions_).setOnes();
  double total = 0;
  for (const auto& t : surface_.elements) total += t.area;
  for (int i = 0; i < triangles(); ++i) {
    const auto& t = surface_.elements[Index(i)];
    const Eigen::Matrix<double, 3, 6> modes = RigidModes(t.centroid);
    for (int c = 0; c < 3; ++c) {
      if (!held(i, c)) rows.col(3 * i + c) = t.area / total * modes.row(c).transpose();
    }
  }
  return rows;
}

MatrixXd ReferenceSystem::Loads(int begin, int end) const {
  MatrixXd loads = MatrixXd::Zero(order(), 3 * Eigen::Index{end - begin});
  for (int j = begin; j < end; ++j) {
    const double traction = 1 / surface_.elements[Index(j)].area;
    for (int i = 0; i < triangles(); ++i) {
      const Eigen::Matrix3d spread = traction * Blocks(i, j).of_traction;
      for (int c = 0; c < 3; ++c) {
        if (!held(j, c)) loads.block<3, 1>(3 * i, 3 * (j - begin) + c) = spread.col(c);
      }
    }
  }
  return loads;
}

Vector3d ReferenceSystem::AtCorner(int corner, const std::vector<Vector3d>& displacement) const {
  Vector3d moved = Vector3d::Zero();
  for (const auto& [triangle, weight] : fit_.shares(corner)) {
    moved += weight * displacement[Index(triangle)];
  }
  for (int c = 0; c < 3; ++c) {
    if (held_nodes_[Index(corner)][Index(c)]) moved[c] = 0;
  }
  return moved;
}

}  // namespace palpate
