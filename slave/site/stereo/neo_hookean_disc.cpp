#include "slave/site/stereo/neo_hookean_disc.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/LU>

#include "slave/mechanics/plate/lobatto.h"

namespace palpate::site {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Voigt's order of a symmetric tensor's components.
constexpr std::array<int, 6> kRow{0, 1, 2, 0, 1, 0}, kColumn{0, 1, 2, 1, 2, 2};

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

// Second Piola-Kirchhoff stress and its derivative by Green's strain (shears doubled).
struct Stress {
  Vector6d S;
  Matrix6d tangent;
};

Stress StressAt(const Matrix3d& F, double J, double mu, double bulk) {
  const Matrix3d C = F.transpose() * F;
  const Matrix3d inverse = C.inverse();
  const double shear = mu / std::cbrt(J * J), trace = C.trace();
  const double pressure = bulk * J * (J - 1);
  Stress stress;
  Vector6d inverse_v, identity_v;
  for (int v = 0; v < 6; ++v) {
    inverse_v[v] = inverse(kRow[Index(v)], kColumn[Index(v)]);
    identity_v[v] = v < 3 ? 1 : 0;
  }
  stress.S = shear * (identity_v - trace / 3 * inverse_v) + pressure * inverse_v;
  const double both = 2 * shear * trace / 9 + bulk * J * (2 * J - 1);
  const double mixed = 2 * shear * trace / 3 - 2 * pressure;
  stress.tangent =
      both * inverse_v * inverse_v.transpose() -
      2 * shear / 3 * (identity_v * inverse_v.transpose() + inverse_v * identity_v.transpose());
  for (int v = 0; v < 6; ++v) {
    for (int w = 0; w < 6; ++w) {
      const int i = kRow[Index(v)], j = kColumn[Index(v)], k = kRow[Index(w)],
                l = kColumn[Index(w)];
      stress.tangent(v, w) +=
          0.5 * mixed * (inverse(i, k) * inverse(j, l) + inverse(i, l) * inverse(j, k));
    }
  }
  return stress;
}

}  // namespace

// Of one element; unknowns column by column of the mesh, as in the whole.
struct NeoHookeanDisc::Work {
  Eigen::Matrix<double, 3, Eigen::Dynamic> u{3, kNodes};
  MatrixXd H{3, 3 * kPoints};                // displacement gradients
  MatrixXd strain{3 * kNodes, 6 * kPoints};  // by the unknowns
  MatrixXd stress{3 * kNodes, 6 * kPoints};  // by the unknowns, times weights
  MatrixXd by_stress{kNodes, 3 * kPoints};   // S times gradients, times weights
  MatrixXd geometric{kNodes, kNodes}, stiffness{3 * kNodes, 3 * kNodes};
  VectorXd S{6 * kPoints}, forces{3 * kNodes};
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
  constexpr int kLevels = DiscMesh::kThrough + 1;
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
  for (int p = 0; p < kPoints; ++p) {
    const Matrix3d F = Matrix3d::Identity() + work->H.middleCols<3>(3 * p);
    const double J = F.determinant();
    if (!(J > 0)) return false;
    const Stress stress = StressAt(F, J, mu_, bulk_);
    const double weight = element.weights[p];
    work->S.segment<6>(6 * p) = weight * stress.S;
    const auto gradient = element.gradients.middleCols<3>(3 * p);
    for (int v = 0; v < 6; ++v) {
      const int i = kRow[Index(v)], j = kColumn[Index(v)];
      double* to = &work->strain(0, 6 * p + v);
      for (int node = 0; node < kNodes; ++node) {
        for (int c = 0; c < 3; ++c) {
          *to++ = i == j ? F(c, i) * gradient(node, i)
                         : F(c, i) * gradient(node, j) + F(c, j) * gradient(node, i);
        }
      }
    }
    if (!with_stiffness) continue;
    work->stress.middleCols<6>(6 * p).noalias() =
        work->strain.middleCols<6>(6 * p) * (weight * stress.tangent);
    Matrix3d S;
    for (int v = 0; v < 6; ++v) {
      S(kRow[Index(v)], kColumn[Index(v)]) = S(kColumn[Index(v)], kRow[Index(v)]) = stress.S[v];
    }
    work->by_stress.middleCols<3>(3 * p).noalias() = gradient * (weight * S);
  }
  return true;
}

void NeoHookeanDisc::AddForces(const Element& element, const Work& work, VectorXd* forces) const {
  constexpr int kBlock = 3 * (DiscMesh::kThrough + 1);
  const VectorXd of_nodes = work.strain * work.S;
  for (int i = 0; i < kColumns; ++i) {
    const int column = element.columns[Index(i)];
    if (column >= mesh_.free_columns()) continue;
    forces->segment<kBlock>(unknown(column, DiscMesh::kThrough * element.layer, 0)) +=
        of_nodes.segment<kBlock>(i * kBlock);
  }
}

void NeoHookeanDisc::AddStiffness(const Element& element, const Work& work,
                                  Matrix* stiffness) const {
  constexpr int kBlock = 3 * (DiscMesh::kThrough + 1);
  MatrixXd K = work.strain * work.stress.transpose();
  const MatrixXd geometric = element.gradients * work.by_stress.transpose();
  for (int c = 0; c < 3; ++c) {
    K(Eigen::seqN(c, kNodes, 3), Eigen::seqN(c, kNodes, 3)) += geometric;
  }
  const int whole = 3 * mesh_.levels(), first = 3 * DiscMesh::kThrough * element.layer;
  for (int j = 0; j < kColumns; ++j) {
    const int column = element.columns[Index(j)];
    if (column >= mesh_.free_columns()) continue;
    for (int i = 0; i < kColumns; ++i) {
      const int row = element.columns[Index(i)];
      if (row > column) continue;
      for (int c = 0; c < kBlock; ++c) {
        const int at = stiffness->outerIndexPtr()[whole * column + first + c] + first +
                       whole * element.positions[Index(i * kColumns + j)];
        const int rows = row == column ? c + 1 : kBlock;
        for (int r = 0; r < rows; ++r) {
          stiffness->valuePtr()[at + r] += K(i * kBlock + r, j * kBlock + c);
        }
      }
    }
  }
}

}  // namespace palpate::site
