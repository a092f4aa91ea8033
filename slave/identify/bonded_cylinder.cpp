#include "slave/identify/bonded_cylinder.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kElements = 10;             // along the radius and along half the height
constexpr Index kSide = 2 * kElements + 1;  // nodes
constexpr double kGrading = 1.5;            // towards the edge, where stress is singular
constexpr Index kLocal = 18, kPressures = 3;
using Element = Eigen::Matrix<double, kLocal + kPressures, kLocal + kPressures>;

std::size_t Place(Index i) {
  return static_cast<std::size_t>(i);
}

// Quadratic shapes and slopes over -1 to 1.
Eigen::Vector3d Shape(double x) {
  return {x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2};
}
Eigen::Vector3d Slope(double x) {
  return {x - 0.5, -2 * x, x + 0.5};
}

VectorXd Places(double length) {
  VectorXd places(kSide);
  for (Index i = 0; i < kSide; i += 2) {
    const double share = static_cast<double>(i) / (kSide - 1);
    places[i] = length * (1 - std::pow(1 - share, kGrading));
  }
  for (Index i = 1; i < kSide; i += 2) places[i] = 0.5 * (places[i - 1] + places[i + 1]);
  return places;
}

// A cylinder with E = 1. Nodes have two indices: the first along the radius, the second along the
// half height.
class HalfCylinder {
 public:
  HalfCylinder(double radius, double half_height, double nu)
      : r_(Places(radius)), z_(Places(half_height)), mu_(0.5 / (1 + nu)) {
    compressibility_ = nu > 1e-6 ? (1 + nu) * (1 - 2 * nu) / nu : 0;
    lambda_ = nu > 1e-6 ? 0 : nu / ((1 + nu) * (1 - 2 * nu));
    mixed_ = nu > 1e-6;
  }

  // Returns the apparent modulus: the force divided by the area, for a shortening equal to the half
  // height.
  double Press() {
    std::vector<Eigen::Triplet<double>> entries;
    for (Index i = 0; i < kElements; ++i) {
      for (Index j = 0; j < kElements; ++j) Add(i, j, &entries);
    }
    Eigen::SparseMatrix<double> K(size(), size());
    K.setFromTriplets(entries.begin(), entries.end());
    VectorXd u = VectorXd::Zero(size());
    for (Index i = 0; i < kSide; ++i) u[2 * Node(i, kSide - 1) + 1] = -z_[kSide - 1];
    const Eigen::SparseMatrix<double> P = Free();
    const Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(P.transpose() * K * P);
    u -= P * solver.solve(P.transpose() * (K * u));
    const VectorXd force = K * u;
    double sum = 0;
    for (Index i = 0; i < kSide; ++i) sum -= force[2 * Node(i, kSide - 1) + 1];
    return sum / (std::numbers::pi * r_[kSide - 1] * r_[kSide - 1]);
  }

 private:
  static Index Node(Index i, Index j) { return i * kSide + j; }
  static Index size() { return 2 * kSide * kSide + kPressures * kElements * kElements; }

  void Add(Index i, Index j, std::vector<Eigen::Triplet<double>>* entries) const {
    Eigen::Array<Index, kLocal + kPressures, 1> place;
    for (Index a = 0; a < 9; ++a) {
      const Index node = Node(2 * i + a / 3, 2 * j + a % 3);
      place.segment<2>(2 * a) << 2 * node, 2 * node + 1;
    }
    for (Index k = 0; k < kPressures; ++k) {
      place[kLocal + k] = 2 * kSide * kSide + kPressures * (i * kElements + j) + k;
    }
    const Element K = Stiffness(i, j);
    for (Index a = 0; a < K.rows(); ++a) {
      for (Index b = 0; b < K.cols(); ++b) entries->emplace_back(place[a], place[b], K(a, b));
    }
  }

  [[nodiscard]] Element Stiffness(Index i, Index j) const {
    const double width = r_[2 * i + 2] - r_[2 * i], height = z_[2 * j + 2] - z_[2 * j];
    const double root = std::sqrt(0.6);
    const std::array<std::pair<double, double>, 3> rule{
        {{-root, 5.0 / 9}, {0, 8.0 / 9}, {root, 5.0 / 9}}};
    Element K = Element::Zero();
    for (const auto& [x, wx] : rule) {
      for (const auto& [y, wy] : rule) {
        const double r = r_[2 * i] + 0.5 * (1 + x) * width;
        const double weight = wx * wy * width * height / 4 * r * 2 * std::numbers::pi;
        AddPoint(Strains(x, y, r, width, height), {1, x, y}, weight, &K);
      }
    }
    return K;
  }

  // Rows: radial, axial, around, shear.
  using StrainMatrix = Eigen::Matrix<double, 4, kLocal>;
  static StrainMatrix Strains(double x, double y, double r, double width, double height) {
    const Eigen::Vector3d Nx = Shape(x), Ny = Shape(y), dx = 2 / width * Slope(x),
                          dy = 2 / height * Slope(y);
    StrainMatrix B = StrainMatrix::Zero();
    for (Index a = 0; a < 9; ++a) {
      const Index p = a / 3, q = a % 3;
      B(0, 2 * a) = B(3, 2 * a + 1) = dx[p] * Ny[q];
      B(1, 2 * a + 1) = B(3, 2 * a) = Nx[p] * dy[q];
      B(2, 2 * a) = Nx[p] * Ny[q] / r;
    }
    return B;
  }

  void AddPoint(const StrainMatrix& B, const Eigen::Vector3d& q, double weight, Element* K) const {
    const Eigen::Vector4d shear(2 * mu_, 2 * mu_, 2 * mu_, mu_);
    const Eigen::RowVectorXd change = B.row(0) + B.row(1) + B.row(2);
    K->topLeftCorner<kLocal, kLocal>() +=
        weight * (B.transpose() * shear.asDiagonal() * B + lambda_ * change.transpose() * change);
    const auto pressures = Eigen::seqN(kLocal, kPressures);
    if (!mixed_) {
      (*K)(pressures, pressures) += weight * q * q.transpose();
      return;
    }
    const MatrixXd coupling = weight * change.transpose() * q.transpose();
    K->topRightCorner<kLocal, kPressures>() += coupling;
    K->bottomLeftCorner<kPressures, kLocal>() += coupling.transpose();
    (*K)(pressures, pressures) -= weight * compressibility_ * q * q.transpose();
  }

  // Unknowns that are not held, as columns.
  static Eigen::SparseMatrix<double> Free() {
    std::vector<char> held(Place(size()), 0);
    for (Index i = 0; i < kSide; ++i) {
      held[Place(2 * Node(0, i))] = 1;          // the axis
      held[Place(2 * Node(i, 0) + 1)] = 1;      // the centre
      held[Place(2 * Node(i, kSide - 1))] = 1;  // no radial displacement at the bonded end
      held[Place(2 * Node(i, kSide - 1) + 1)] = 1;
    }
    std::vector<Eigen::Triplet<double>> picked;
    for (Index i = 0; i < size(); ++i) {
      if (held[Place(i)] == 0) picked.emplace_back(i, picked.size(), 1);
    }
    Eigen::SparseMatrix<double> P(size(), static_cast<Index>(picked.size()));
    P.setFromTriplets(picked.begin(), picked.end());
    return P;
  }

  VectorXd r_, z_;
  double mu_, compressibility_ = 0, lambda_ = 0;
  bool mixed_ = true;
};

}  // namespace

double BondedCylinderFactor(double slenderness, double nu) {
  if (!(slenderness >= 0.01 && slenderness <= 20)) {
    RefuseValue("diameter / height", slenderness, "0.01 to 20");
  }
  if (!(nu >= -0.9 && nu <= 0.5)) RefuseValue("nu", nu, "-0.9 to 0.5");
  return HalfCylinder(slenderness, 1, nu).Press();
}

}  // namespace palpate::identify
