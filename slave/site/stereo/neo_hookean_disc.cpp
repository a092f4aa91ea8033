#include "slave/site/stereo/neo_hookean_disc.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "slave/mechanics/plate/lobatto.h"

namespace palpate::site {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

std::size_t Index(int i) {
  return static_cast<std::size_t>(i);
}

// Polynomials of a degree by their values at even places, at the points of Gauss's rule.
struct Line {
  explicit Line(int degree)
      : rule(plate::GaussLegendre(degree + 1)),
        shapes(plate::Interpolate(VectorXd::LinSpaced(degree + 1, 0, 1), rule.points)) {}
  plate::Quadrature rule;
  plate::Interpolation shapes;
};

Matrix3d CofactorOf(const Matrix3d& F) {
  Matrix3d cofactor;
  cofactor << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return cofactor;
}

// First Piola-Kirchhoff stress P = dW / dF and its derivative over vec(F), column by column: with
// G = F^-T, c = mu J^(-2/3) and q = K J (J - 1),
//
//   P = c (F - tr(F^T F) / 3 G) + q G
//   dP_ai / dF_bj = c (d_ab d_ij - 2/3 (F_ai G_bj + G_ai F_bj)) + (c tr / 3 - q) G_aj G_bi
//                   + (2/9 c tr + K J (2 J - 1)) G_ai G_bj
struct Stress {
  Matrix3d P;
  Matrix9d tangent;
};

// From H = F - I, so that small strains keep their digits. False: not J > 0.
bool StressAt(const Matrix3d& H, double mu, double bulk, bool with_tangent, Stress* stress) {
  const Matrix3d minors = CofactorOf(H);
  const Matrix3d area = H.trace() * Matrix3d::Identity() - H.transpose() + minors;  // cof F - I
  const double volume = H.trace() + minors.trace() + H.determinant();               // J - 1
  const double stretch = 2 * H.trace() + H.squaredNorm();                           // tr F^T F - 3
  const double J = 1 + volume;
  if (!(J > 0)) return false;
  const Matrix3d F = Matrix3d::Identity() + H, G = (Matrix3d::Identity() + area) / J;
  const double c = mu / std::cbrt(J * J), q = bulk * J * volume, trace = 3 + stretch;
  stress->P = c / J * (H - area + volume * F - stretch / 3 * (Matrix3d::Identity() + area)) + q * G;
  if (!with_tangent) return true;
  const auto f = F.reshaped(), g = G.reshaped();
  stress->tangent = (2 * c * trace / 9 + bulk * J * (2 * J - 1)) * g * g.transpose() -
                    2 * c / 3 * (f * g.transpose() + g * f.transpose());
  stress->tangent.diagonal().array() += c;
  const double crossed = c * trace / 3 - q;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      stress->tangent.block<3, 3>(3 * i, 3 * j) += crossed * G.col(j) * G.col(i).transpose();
    }
  }
  return true;
}

}  // namespace

// Of one element. The stiffness between components a <= b of all its nodes is the product of the
// shape functions' gradients with theirs times dP_a / dF_b, one such block beside the other.
struct NeoHookeanDisc::Work {
  static constexpr std::array<int, 6> kFirst{0, 0, 0, 1, 1, 2}, kSecond{0, 1, 2, 1, 2, 2};
  Eigen::Matrix<double, 3, Eigen::Dynamic> u{3, kNodes}, forces{3, kNodes};
  MatrixXd H{3, 3 * kPoints};                // displacement gradients
  MatrixXd P{3, 3 * kPoints};                // stresses, times weights
  MatrixXd turned{kNodes * 6, 3 * kPoints};  // gradients times tangents, times weights
  MatrixXd stiffness{kNodes, kNodes * 6};
};

NeoHookeanDisc::NeoHookeanDisc(const DiscMesh& mesh, double nu)
    : mesh_(mesh), mu_(0.5 / (1 + nu)), bulk_(1 / (3 * (1 - 2 * nu))) {
  for (int ring = 0; ring < mesh.rings(); ++ring) {
    for (int ray = 0; ray < mesh.rays(); ++ray) {
      for (int layer = 0; layer < mesh.layers(); ++layer) AddElement(ring, ray, layer);
    }
  }
  FindPattern();
  free_.setOnes(size());
  for (int circle = 0; circle + 1 < mesh.circle_lines(); ++circle) {
    for (int ray = 0; ray < mesh.ray_lines(); ++ray) {
      const auto held = mesh.Held(circle, ray);
      for (int i = 0; i < 3 * mesh.levels(); ++i) {
        if (held[Index(i % 3)]) free_[unknown(mesh.column(circle, ray), i / 3, i % 3)] = 0;
      }
    }
  }
}

void NeoHookeanDisc::AddElement(int ring, int ray, int layer) {
  static const Line along(DiscMesh::kAcross), through(DiscMesh::kThrough);
  Element element;
  element.columns = mesh_.element(ring, ray);
  element.layer = layer;
  element.gradients.resize(kNodes, 3 * kPoints);
  element.weights.resize(kPoints);
  const double height = mesh_.thickness() / mesh_.layers();
  int point = 0;
  for (int p = 0; p < kAlong; ++p) {
    for (int q = 0; q < kAlong; ++q) {
      Eigen::Matrix<double, kColumns, 1> value;
      Eigen::Matrix<double, kColumns, 2> slope;
      Eigen::Matrix2d jacobian = Eigen::Matrix2d::Zero();
      for (int i = 0; i < kColumns; ++i) {
        const int a = i / kAlong, b = i % kAlong;
        value[i] = along.shapes.value(p, a) * along.shapes.value(q, b);
        slope(i, 0) = along.shapes.slope(p, a) * along.shapes.value(q, b);
        slope(i, 1) = along.shapes.value(p, a) * along.shapes.slope(q, b);
        jacobian += mesh_.place(element.columns[Index(i)]) * slope.row(i);
      }
      const Eigen::Matrix<double, kColumns, 2> gradient = slope * jacobian.inverse();
      const double area = along.rule.weights[p] * along.rule.weights[q] * jacobian.determinant();
      for (int r = 0; r <= DiscMesh::kThrough; ++r, ++point) {
        for (int i = 0; i < kColumns; ++i) {
          for (int l = 0; l <= DiscMesh::kThrough; ++l) {
            const int node = i * (DiscMesh::kThrough + 1) + l;
            element.gradients(node, 3 * point) = gradient(i, 0) * through.shapes.value(r, l);
            element.gradients(node, 3 * point + 1) = gradient(i, 1) * through.shapes.value(r, l);
            element.gradients(node, 3 * point + 2) = value[i] * through.shapes.slope(r, l) / height;
          }
        }
        element.weights[point] = area * through.rule.weights[r] * height;
      }
    }
  }
  elements_.push_back(std::move(element));
}

void NeoHookeanDisc::FindPattern() {
  upper_.resize(Index(mesh_.free_columns()));
  for (const Element& element : elements_) {
    for (const int row : element.columns) {
      for (const int column : element.columns) {
        if (row <= column && column < mesh_.free_columns()) upper_[Index(column)].push_back(row);
      }
    }
  }
  for (auto& rows : upper_) {
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  }
  for (Element& element : elements_) {
    for (std::size_t i = 0; i < element.columns.size(); ++i) {
      for (std::size_t j = 0; j < element.columns.size(); ++j) {
        const int row = element.columns[i], column = element.columns[j];
        if (row > column || column >= mesh_.free_columns()) continue;
        const auto& rows = upper_[Index(column)];
        element.positions[i * element.columns.size() + j] =
            static_cast<int>(std::ranges::lower_bound(rows, row) - rows.begin());
      }
    }
  }
}

NeoHookeanDisc::Matrix NeoHookeanDisc::EmptyMatrix() const {
  const int block = 3 * mesh_.levels();
  std::size_t entries = 0;
  for (const auto& rows : upper_) entries += rows.size() * Index(block * block);
  Matrix matrix(size(), size());
  matrix.reserve(static_cast<Eigen::Index>(entries));
  for (int column = 0; column < mesh_.free_columns(); ++column) {
    for (int c = 0; c < block; ++c) {
      matrix.startVec(block * column + c);
      for (const int other : upper_[Index(column)]) {
        const int rows = other == column ? c + 1 : block;
        for (int r = 0; r < rows; ++r) matrix.insertBack(block * other + r, block * column + c) = 0;
      }
    }
  }
  matrix.finalize();
  return matrix;
}

VectorXd NeoHookeanDisc::ToolLoad() const {
  static const Line along(DiscMesh::kAcross);
  VectorXd load = VectorXd::Zero(size());
  for (int ring = 0; ring < mesh_.inner_rings(); ++ring) {
    for (int ray = 0; ray < mesh_.rays(); ++ray) {
      const auto columns = mesh_.element(ring, ray);
      for (int k = 0; k < kColumns; ++k) {
        const int p = k / kAlong, q = k % kAlong;
        Eigen::Matrix2d jacobian = Eigen::Matrix2d::Zero();
        for (int i = 0; i < kColumns; ++i) {
          const int a = i / kAlong, b = i % kAlong;
          jacobian += mesh_.place(columns[Index(i)]) *
                      Eigen::RowVector2d(along.shapes.slope(p, a) * along.shapes.value(q, b),
                                         along.shapes.value(p, a) * along.shapes.slope(q, b));
        }
        const double area = along.rule.weights[p] * along.rule.weights[q] * jacobian.determinant();
        for (int i = 0; i < kColumns; ++i) {
          load[unknown(columns[Index(i)], mesh_.levels() - 1, 2)] -=
              area * along.shapes.value(p, i / kAlong) * along.shapes.value(q, i % kAlong);
        }
      }
    }
  }
  return load / (-load.sum() * (mesh_.is_quarter() ? 4 : 2));
}

bool NeoHookeanDisc::Forces(const VectorXd& u, VectorXd* forces) const {
  return Accumulate(u, forces, nullptr);
}

bool NeoHookeanDisc::Linearise(const VectorXd& u, VectorXd* forces, Matrix* stiffness) const {
  return Accumulate(u, forces, stiffness);
}

bool NeoHookeanDisc::Accumulate(const VectorXd& u, VectorXd* forces, Matrix* stiffness) const {
  Work work;
  forces->setZero(size());
  if (stiffness != nullptr) stiffness->coeffs().setZero();
  for (const Element& element : elements_) {
    if (!Integrate(element, u, stiffness != nullptr, &work)) return false;
    AddForces(element, work, forces);
    if (stiffness != nullptr) AddStiffness(element, work, stiffness);
  }
  *forces = forces->cwiseProduct(free_);
  if (stiffness != nullptr) HoldMirrorPlanes(stiffness);
  return true;
}

// Their rows and columns become those of the identity.
void NeoHookeanDisc::HoldMirrorPlanes(Matrix* stiffness) const {
  for (int column = 0; column < size(); ++column) {
    for (Matrix::InnerIterator entry(*stiffness, column); entry; ++entry) {
      const double free = free_[entry.row()] * free_[column];
      if (free == 0) entry.valueRef() = entry.row() == column ? 1 : 0;
    }
  }
}

bool NeoHookeanDisc::Integrate(const Element& element, const VectorXd& u, bool with_stiffness,
                               Work* work) const {
  for (int i = 0; i < kColumns; ++i) {
    const int column = element.columns[Index(i)];
    if (column < mesh_.free_columns()) {
      work->u.middleCols<kLevels>(i * kLevels) =
          u.segment<3 * kLevels>(unknown(column, DiscMesh::kThrough * element.layer, 0))
              .reshaped(3, kLevels);
    } else {
      work->u.middleCols<kLevels>(i * kLevels).setZero();
    }
  }
  work->H.noalias() = work->u * element.gradients;
  Stress stress;
  for (int p = 0; p < kPoints; ++p) {
    const Matrix3d H = work->H.middleCols<3>(3 * p);
    if (!StressAt(H, mu_, bulk_, with_stiffness, &stress)) return false;
    const double weight = element.weights[p];
    work->P.middleCols<3>(3 * p) = weight * stress.P;
    if (!with_stiffness) continue;
    for (std::size_t k = 0; k < 6; ++k) {
      // Of dP_ai / dF_bj: row i, column j.
      const Matrix3d of_pair = weight * stress.tangent(Eigen::seqN(Work::kFirst[k], 3, 3),
                                                       Eigen::seqN(Work::kSecond[k], 3, 3));
      work->turned.block<kNodes, 3>(static_cast<Eigen::Index>(k) * kNodes, 3 * p).noalias() =
          element.gradients.middleCols<3>(3 * p) * of_pair.transpose();
    }
  }
  work->forces.noalias() = work->P * element.gradients.transpose();
  if (with_stiffness) work->stiffness.noalias() = element.gradients * work->turned.transpose();
  return true;
}

void NeoHookeanDisc::AddForces(const Element& element, const Work& work, VectorXd* forces) const {
  for (int i = 0; i < kColumns; ++i) {
    const int column = element.columns[Index(i)];
    if (column >= mesh_.free_columns()) continue;
    forces->segment<3 * kLevels>(unknown(column, DiscMesh::kThrough * element.layer, 0)) +=
        work.forces.middleCols<kLevels>(i * kLevels).reshaped();
  }
}

void NeoHookeanDisc::AddStiffness(const Element& element, const Work& work,
                                  Matrix* stiffness) const {
  const int whole = 3 * mesh_.levels(), first = 3 * DiscMesh::kThrough * element.layer;
  const auto block = [&](int a, int b) {  // between components a <= b
    return work.stiffness.middleCols<kNodes>(kNodes * (a == 0 ? b : a + b + 1));
  };
  const auto entry = [&](int i, int a, int j, int b) {
    return a <= b ? block(a, b)(i, j) : block(b, a)(j, i);
  };
  for (int j = 0; j < kColumns; ++j) {
    const int column = element.columns[Index(j)];
    if (column >= mesh_.free_columns()) continue;
    for (int i = 0; i < kColumns; ++i) {
      const int row = element.columns[Index(i)];
      if (row > column) continue;
      for (int c = 0; c < 3 * kLevels; ++c) {
        double* to = stiffness->valuePtr() +
                     stiffness->outerIndexPtr()[whole * column + first + c] + first +
                     whole * element.positions[Index(i * kColumns + j)];
        const int rows = row == column ? c + 1 : 3 * kLevels;
        for (int r = 0; r < rows; ++r) {
          to[r] += entry(i * kLevels + r / 3, r % 3, j * kLevels + c / 3, c % 3);
        }
      }
    }
  }
}

}  // namespace palpate::site
