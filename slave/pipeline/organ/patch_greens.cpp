#include "slave/pipeline/organ/patch_greens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int kTogether = 24;  // right-hand sides: a good size for the solver

// Gradients of the volume coordinates, row per corner [1/m], and the volume [m^3].
std::pair<Eigen::Matrix<double, 4, 3>, double> GradientsOf(const SolidMesh& mesh,
                                                           const std::array<int, 4>& tet) {
  Matrix3d edges;
  for (int i = 0; i < 3; ++i) {
    edges.row(i) = mesh.nodes[Index(tet[Index(i + 1)])] - mesh.nodes[Index(tet[0])];
  }
  Eigen::Matrix<double, 4, 3> gradients;
  gradients.bottomRows<3>() = edges.inverse().transpose();
  gradients.row(0) = -gradients.bottomRows<3>().colwise().sum();
  return {gradients, std::abs(edges.determinant()) / 6};
}

}  // namespace

PatchGreens::PatchGreens(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
                         double poisson_ratio, std::vector<int> watched)
    : mesh_(mesh),
      surface_(SurfaceOf(mesh)),
      watched_(std::move(watched)),
      lambda_(young_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))),
      mu_(young_modulus / (2 * (1 + poisson_ratio))),
      unit_(young_modulus),
      stiffness_(AssembleTetStiffness(mesh, held, poisson_ratio, TetElement::kTet4)),
      factor_(stiffness_.lower),
      area_(mesh.nodes.size(), 0),
      normals_(mesh.nodes.size(), Vector3d::Zero()) {
  unit_ *= stiffness_.length_unit;
  for (const auto& t : surface_.triangles) {
    const Vector3d a = surface_.nodes[Index(t[0])];
    const Vector3d twice = (surface_.nodes[Index(t[1])] - a).cross(surface_.nodes[Index(t[2])] - a);
    for (const int node : t) {
      area_[Index(node)] += twice.norm() / 6;
      normals_[Index(node)] += twice;
    }
  }
  for (std::size_t n = 0; n < area_.size(); ++n) {
    normals_[n].stableNormalize();
    if (area_[n] > 0) skin_.push_back(static_cast<int>(n));
  }
  PlaceModes();
}

// Bumps as wide as they are apart, of sum one.
void PatchGreens::PlaceModes() {
  std::vector<Vector3d> middles;
  for (const auto& tet : mesh_.tets) {
    Vector3d sum = Vector3d::Zero();
    for (const int node : tet) sum += mesh_.nodes[Index(node)] / 4;
    middles.push_back(sum);
  }
  const auto count = static_cast<Eigen::Index>(middles.size());
  MatrixXd squared(count, kModes);
  Eigen::VectorXd nearest =
      Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  Eigen::Index next = 0;
  for (int m = 0; m < kModes; ++m) {
    const Vector3d centre = middles[static_cast<std::size_t>(next)];
    for (Eigen::Index e = 0; e < count; ++e) {
      squared(e, m) = (middles[static_cast<std::size_t>(e)] - centre).squaredNorm();
    }
    nearest = nearest.cwiseMin(squared.col(m));
    nearest.maxCoeff(&next);
  }
  modes_ = (-squared / (2 * nearest.maxCoeff())).array().exp();
  modes_.array().colwise() /= modes_.rowwise().sum().array().eval();
}

LoadPatch PatchGreens::PatchAt(const Vector3d& p_O, const Vector3d& n_O, double width) const {
  LoadPatch patch{.p_O = p_O, .n_O = n_O.stableNormalized(), .width = width};
  patch.along_O = patch.n_O.unitOrthogonal();
  patch.across_O = patch.n_O.cross(patch.along_O);
  return patch;
}

std::vector<int> PatchGreens::Spread(int count, double* spacing) const {
  std::vector<int> free, chosen;
  for (const int node : skin_) {
    if (!IsHeld(node)) free.push_back(node);
  }
  std::vector<double> away(free.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  while (static_cast<int>(chosen.size()) < count && away[next] > 0) {
    chosen.push_back(free[next]);
    for (std::size_t i = 0; i < free.size(); ++i) {
      const double d = (mesh_.nodes[Index(free[i])] - mesh_.nodes[Index(chosen.back())]).norm();
      away[i] = std::min(away[i], d);
    }
    next = static_cast<std::size_t>(std::ranges::max_element(away) - away.begin());
  }
  *spacing = away[next];
  return chosen;
}

MatrixXd PatchGreens::Weights(const LoadPatch& patch) const {
  MatrixXd weights = MatrixXd::Zero(static_cast<Eigen::Index>(skin_.size()), 1 + kShifts);
  const double variance = patch.width * patch.width;
  for (std::size_t i = 0; i < skin_.size(); ++i) {
    if (IsHeld(skin_[i])) continue;                               // what acts there moves nothing
    if (normals_[Index(skin_[i])].dot(patch.n_O) <= 0) continue;  // the other side of a thin part
    const Vector3d from = mesh_.nodes[Index(skin_[i])] - patch.p_O;
    const double w = area_[Index(skin_[i])] * std::exp(-from.squaredNorm() / (2 * variance));
    weights.row(static_cast<Eigen::Index>(i)) =
        w * Eigen::RowVector4d(1, from.dot(patch.along_O) / variance,
                               from.dot(patch.across_O) / variance, from.squaredNorm() / variance);
  }
  // d (w / sum w) = (dw - w sum dw / sum w) / sum w
  const Eigen::RowVectorXd sums = weights.colwise().sum();
  for (int k = 1; k <= kShifts; ++k) weights.col(k) -= weights.col(0) * (sums[k] / sums[0]);
  return weights / sums[0];
}

bool PatchGreens::IsHeld(int node) const {
  return std::ranges::any_of(stiffness_.row[Index(node)], [](int row) { return row < 0; });
}

bool PatchGreens::CanPress(const LoadPatch& patch) const {
  return Weights(patch).allFinite();
}

void PatchGreens::AddRow(int node, int axis, double value, Eigen::Index column,
                         MatrixXd* right) const {
  const int row = stiffness_.row[Index(node)][Index(axis)];
  if (row >= 0) (*right)(row, column) += value;
}

double PatchGreens::Solution(const MatrixXd& solved, int node, int axis,
                             Eigen::Index column) const {
  const int row = stiffness_.row[Index(node)][Index(axis)];
  return row >= 0 ? solved(row, column) : 0;
}

Matrix3d PatchGreens::ComplianceOf(const MatrixXd& solved, Eigen::Index from,
                                   const MatrixXd& weights) const {
  Matrix3d compliance = Matrix3d::Zero();
  for (std::size_t i = 0; i < skin_.size(); ++i) {
    const double w = weights(static_cast<Eigen::Index>(i), 0);
    for (int r = 0; r < 3 && w != 0; ++r) {
      for (int c = 0; c < 3; ++c) {
        compliance(r, c) += w * Solution(solved, skin_[i], r, from + c) / unit_;
      }
    }
  }
  return compliance;
}

void PatchGreens::Keep(const MatrixXd& solved, Eigen::Index from, int column, Field* field) const {
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        (*field)(column, 9 * static_cast<Eigen::Index>(i) + Eigen::Index{3} * r + c) =
            static_cast<float>(Solution(solved, watched_[i], r, from + c) / unit_);
      }
    }
  }
}

void PatchGreens::Press(LoadPatch* patch, Field* field) {
  const MatrixXd weights = Weights(*patch);
  MatrixXd columns = MatrixXd::Zero(stiffness_.lower.rows(), 3 * (1 + kShifts));
  for (std::size_t i = 0; i < skin_.size(); ++i) {
    for (int k = 0; k <= kShifts; ++k) {
      const double w = weights(static_cast<Eigen::Index>(i), k);
      for (int c = 0; c < 3 && w != 0; ++c)
        AddRow(skin_[i], c, w, Eigen::Index{3} * k + c, &columns);
    }
  }
  factor_.Solve(columns.data(), static_cast<int>(columns.cols()));
  for (int k = 0; k <= kShifts; ++k) Keep(columns, Eigen::Index{3} * k, k, field);
  pressed_ = columns.leftCols<3>() / unit_;
  patch->compliance_O = ComplianceOf(columns, 0, weights);
}

std::vector<Eigen::VectorXf> PatchGreens::PressEach(std::vector<LoadPatch>* patches) {
  std::vector<Eigen::VectorXf> pressed;
  Field field = Field::Zero(kColumns, 9 * static_cast<Eigen::Index>(watched_.size()));
  constexpr std::size_t kPatches = kTogether / 3;
  for (std::size_t begin = 0; begin < patches->size(); begin += kPatches) {
    const std::size_t end = std::min(patches->size(), begin + kPatches);
    MatrixXd columns = MatrixXd::Zero(stiffness_.lower.rows(), kTogether);
    std::vector<MatrixXd> all;
    for (std::size_t p = begin; p < end; ++p) {
      const MatrixXd& weights = all.emplace_back(Weights((*patches)[p]));
      for (std::size_t i = 0; i < skin_.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
          AddRow(skin_[i], c, weights(static_cast<Eigen::Index>(i), 0),
                 static_cast<Eigen::Index>(3 * (p - begin)) + c, &columns);
        }
      }
    }
    factor_.Solve(columns.data(), kTogether);
    for (std::size_t p = begin; p < end; ++p) {
      const auto from = static_cast<Eigen::Index>(3 * (p - begin));
      (*patches)[p].compliance_O = ComplianceOf(columns, from, all[p - begin]);
      Keep(columns, from, 0, &field);
      pressed.emplace_back(field.row(0));
    }
  }
  return pressed;
}

void PatchGreens::Soften(Field* field) {
  MatrixXd columns = MatrixXd::Zero(stiffness_.lower.rows(), 3 * kModes);
  for (std::size_t e = 0; e < mesh_.tets.size(); ++e) {
    const auto& tet = mesh_.tets[e];
    const auto [gradients, volume] = GradientsOf(mesh_, tet);
    for (int c = 0; c < 3; ++c) {
      Matrix3d slope = Matrix3d::Zero();  // d u_i / d x_j
      for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) {
          slope.row(i) += Solution(pressed_, tet[Index(a)], i, c) * gradients.row(a);
        }
      }
      const Matrix3d stress =
          lambda_ * slope.trace() * Matrix3d::Identity() + mu_ * (slope + slope.transpose());
      const Eigen::Matrix<double, 4, 3> forces = volume * gradients * stress;
      for (int m = 0; m < kModes; ++m) {
        const double phi = modes_(static_cast<Eigen::Index>(e), m);
        for (int a = 0; a < 4; ++a) {
          for (int i = 0; i < 3; ++i) {
            AddRow(tet[Index(a)], i, -phi * forces(a, i), Eigen::Index{3} * m + c, &columns);
          }
        }
      }
    }
  }
  factor_.Solve(columns.data(), static_cast<int>(columns.cols()));
  for (int m = 0; m < kModes; ++m) Keep(columns, Eigen::Index{3} * m, 1 + kShifts + m, field);
}

}  // namespace palpate
