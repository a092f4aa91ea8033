#include "slave/site/points/neo_hookean_disc.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/LU>

#include "shared/geometry/index.h"
#include "slave/mechanics/plate/lobatto.h"

namespace palpate::site {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Polynomials of a degree by their values at even places, at the points of Gauss's rule.
struct Line {
  explicit Line(int degree)
      : rule(plate::GaussLegendre(degree + 1)),
        shapes(plate::Interpolate(VectorXd::LinSpaced(degree + 1, 0, 1), rule.points)) {}
  plate::Quadrature rule;
  plate::Interpolation shapes;
};

// A point of Gauss's rule on the face of an element, cubic in both directions.
struct FacePoint {
  static constexpr int kColumns = DiscMesh::kElementColumns, kSide = DiscMesh::kAcross + 1;
  Eigen::Matrix<double, kColumns, 1> value;     // of the shape functions
  Eigen::Matrix<double, kColumns, 2> gradient;  // [1 / length]
  double area = 0;
};

FacePoint FacePointOf(const DiscMesh& mesh, const std::array<int, FacePoint::kColumns>& columns,
                      int point) {
  static const Line line(DiscMesh::kAcross);
  const int p = point / FacePoint::kSide, q = point % FacePoint::kSide;
  FacePoint at;
  Eigen::Matrix<double, FacePoint::kColumns, 2> slope;
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Zero();
  for (int i = 0; i < FacePoint::kColumns; ++i) {
    const int a = i / FacePoint::kSide, b = i % FacePoint::kSide;
    at.value[i] = line.shapes.value(p, a) * line.shapes.value(q, b);
    slope(i, 0) = line.shapes.slope(p, a) * line.shapes.value(q, b);
    slope(i, 1) = line.shapes.value(p, a) * line.shapes.slope(q, b);
    jacobian += mesh.place(columns[Index(i)]) * slope.row(i);
  }
  at.gradient = slope * jacobian.inverse();
  at.area = line.rule.weights[p] * line.rule.weights[q] * jacobian.determinant();
  return at;
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

NeoHookeanDisc::NeoHookeanDisc(const DiscMesh& mesh, double nu, double tension)
    : mesh_(mesh), rubber_(nu, tension) {
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
  static const Line through(DiscMesh::kThrough);
  Element element;
  element.columns = mesh_.element(ring, ray);
  element.layer = layer;
  element.gradients.resize(kNodes, 3 * kPoints);
  element.weights.resize(kPoints);
  const double height = mesh_.thickness() / mesh_.layers();
  for (int point = 0; point < kPoints; ++point) {
    const FacePoint face = FacePointOf(mesh_, element.columns, point / kLevels);
    const int r = point % kLevels;
    for (int node = 0; node < kNodes; ++node) {
      const int i = node / kLevels, l = node % kLevels;
      element.gradients.block<1, 2>(node, 3 * point) =
          face.gradient.row(i) * through.shapes.value(r, l);
      element.gradients(node, 3 * point + 2) = face.value[i] * through.shapes.slope(r, l) / height;
    }
    element.weights[point] = face.area * through.rule.weights[r] * height;
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
  VectorXd load = VectorXd::Zero(size());
  for (int ring = 0; ring < mesh_.inner_rings(); ++ring) {
    for (int ray = 0; ray < mesh_.rays(); ++ray) {
      const auto columns = mesh_.element(ring, ray);
      for (int point = 0; point < kColumns; ++point) {
        const FacePoint face = FacePointOf(mesh_, columns, point);
        for (int i = 0; i < kColumns; ++i) {
          load[unknown(columns[Index(i)], mesh_.levels() - 1, 2)] -= face.area * face.value[i];
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
  NeoHookean::Stress stress;
  for (int p = 0; p < kPoints; ++p) {
    const Matrix3d H = work->H.middleCols<3>(3 * p);
    if (!rubber_.At(H, with_stiffness, &stress)) return false;
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
