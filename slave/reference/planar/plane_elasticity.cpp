#include "slave/reference/planar/plane_elasticity.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "slave/mesh/index.h"

namespace palpate::simulation {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

constexpr double kPressureShift = 1e-6;  // in units of pressure mass / G
constexpr int kRefinements = 6;          // at most; two or three are the rule

// Gradients of the six shape functions with respect to the barycentric coordinates L0, L1, L2.
Eigen::Matrix<double, 6, 3> BarycentricGradients(const Eigen::Vector3d& L) {
  Eigen::Matrix<double, 6, 3> g = Eigen::Matrix<double, 6, 3>::Zero();
  for (int i = 0; i < 3; ++i) {
    g(i, i) = 4 * L[i] - 1;
    const int j = (i + 1) % 3;
    g(3 + i, i) = 4 * L[j];
    g(3 + i, j) = 4 * L[i];
  }
  return g;
}

// ElementIntegrals holds the integrals over one straight-sided triangle of products of shape
// functions.
struct ElementIntegrals {
  std::array<Matrix6, 3> G;   // (dNi/dx, dNj/dx), (dNi/dx, dNj/dy), (dNi/dy, dNj/dy)
  std::array<Matrix36, 2> D;  // (Lk, dNj/dx), (Lk, dNj/dy)
  Eigen::Matrix3d M;          // (Lk, Ll)
};

// Middle-point rule: exact for the products of linear functions that appear here.
ElementIntegrals Integrate(const std::array<Eigen::Vector2d, 3>& p) {
  static const std::array<Eigen::Vector3d, 3> kPoints{
      Eigen::Vector3d{0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
  static const std::array<Eigen::Matrix<double, 6, 3>, 3> kGradients{
      BarycentricGradients(kPoints[0]), BarycentricGradients(kPoints[1]),
      BarycentricGradients(kPoints[2])};
  const double twice = Orientation(p[0], p[1], p[2]);
  Eigen::Matrix<double, 3, 2> dL;  // dL/dx, dL/dy
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d opposite = p[(i + 2) % 3] - p[(i + 1) % 3];
    dL.row(static_cast<Eigen::Index>(i)) << -opposite.y() / twice, opposite.x() / twice;
  }
  ElementIntegrals e;
  for (auto& m : e.G) m.setZero();
  for (auto& m : e.D) m.setZero();
  const double weight = twice / 6;
  for (std::size_t q = 0; q < 3; ++q) {
    const Eigen::Matrix<double, 6, 2> dN = kGradients[q] * dL;
    e.G[0] += weight * dN.col(0) * dN.col(0).transpose();
    e.G[1] += weight * dN.col(0) * dN.col(1).transpose();
    e.G[2] += weight * dN.col(1) * dN.col(1).transpose();
    e.D[0] += weight * kPoints[q] * dN.col(0).transpose();
    e.D[1] += weight * kPoints[q] * dN.col(1).transpose();
  }
  e.M = twice / 24 * (Eigen::Matrix3d::Ones() + Eigen::Matrix3d::Identity());
  return e;
}

// The constants of the weak form; lambda = 0 if the pressure is an unknown.
struct Constants {
  double G = 0, lambda = 0;
  bool mixed = false;
  double compliance = 0;  // 1 / lambda of the pressure equation
};

Constants ConstantsOf(const PlaneMaterial& m) {
  Constants c;
  c.G = m.E / (2 * (1 + m.nu));
  if (m.plane == Plane::kStress) {
    c.lambda = m.E * m.nu / (1 - m.nu * m.nu);
    return c;
  }
  // Below 0.4 nothing locks, and near nu = 0 the pressure equation would degenerate.
  c.mixed = m.nu > 0.4;
  if (c.mixed) {
    c.compliance = (1 + m.nu) * (1 - 2 * m.nu) / (m.E * m.nu);
  } else {
    c.lambda = m.E * m.nu / ((1 + m.nu) * (1 - 2 * m.nu));
  }
  return c;
}

// Equations: two per node, then one per corner for the pressure if the form is mixed.
class System {
 public:
  System(const QuadraticMesh& mesh, const Constants& constants)
      : mesh_(mesh),
        c_(constants),
        node_dofs_(2 * static_cast<int>(mesh.nodes.size())),
        size_(node_dofs_ + (constants.mixed ? mesh.corner_count : 0)) {
    if (c_.mixed) pressure_mass_.assign(Index(mesh.corner_count), 0);
    entries_.reserve(mesh.triangles.size() * (c_.mixed ? 144 : 78));
    for (const auto& triangle : mesh.triangles) Add(triangle);
  }

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] int node_dofs() const { return node_dofs_; }
  // Returns a third of the area of the triangles around the corner of pressure equation `k`.
  [[nodiscard]] double pressure_mass(int k) const { return pressure_mass_[Index(k - node_dofs_)]; }
  // Lower half of the whole symmetric matrix.
  [[nodiscard]] Sparse Matrix() const {
    Sparse K(size_, size_);
    K.setFromTriplets(entries_.begin(), entries_.end());
    return K;
  }

 private:
  void Put(int row, int column, double value) {
    if (row >= column) entries_.emplace_back(row, column, value);
  }
  void Add(const std::array<int, 6>& v) {
    const auto e =
        Integrate({mesh_.nodes[Index(v[0])], mesh_.nodes[Index(v[1])], mesh_.nodes[Index(v[2])]});
    const double stiff = c_.lambda + 2 * c_.G;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        const int row = 2 * v[Index(i)], column = 2 * v[Index(j)];
        const double xx = e.G[0](i, j), yy = e.G[2](i, j), xy = e.G[1](i, j), yx = e.G[1](j, i);
        Put(row, column, stiff * xx + c_.G * yy);
        Put(row + 1, column + 1, stiff * yy + c_.G * xx);
        Put(row, column + 1, c_.lambda * xy + c_.G * yx);
        Put(row + 1, column, c_.lambda * yx + c_.G * xy);
      }
    }
    if (c_.mixed) AddPressure(v, e);
  }
  void AddPressure(const std::array<int, 6>& v, const ElementIntegrals& e) {
    for (int k = 0; k < 3; ++k) {
      const int row = node_dofs_ + v[Index(k)];
      pressure_mass_[Index(v[Index(k)])] += e.M.row(k).sum();
      for (int j = 0; j < 6; ++j) {
        Put(row, 2 * v[Index(j)], e.D[0](k, j));
        Put(row, 2 * v[Index(j)] + 1, e.D[1](k, j));
      }
      for (int l = 0; l < 3; ++l) Put(row, node_dofs_ + v[Index(l)], -c_.compliance * e.M(k, l));
    }
  }

  const QuadraticMesh& mesh_;
  Constants c_;
  int node_dofs_, size_;
  std::vector<double> pressure_mass_;
  std::vector<Eigen::Triplet<double>> entries_;
};

// Numbers the unknowns; -1: prescribed.
std::vector<int> NumberUnknowns(const System& system, const Prescribed& prescribed, int* count) {
  std::vector<int> number(Index(system.size()), -1);
  *count = 0;
  for (int k = 0; k < system.size(); ++k) {
    if (k < system.node_dofs() && prescribed(k / 2, k % 2)) continue;
    number[Index(k)] = (*count)++;
  }
  return number;
}

Sparse FreePart(const Sparse& K, const std::vector<int>& number, int count) {
  Sparse part(count, count);
  part.reserve(K.nonZeros());
  for (int column = 0; column < K.outerSize(); ++column) {
    if (number[Index(column)] < 0) continue;
    part.startVec(number[Index(column)]);
    for (Sparse::InnerIterator it(K, column); it; ++it) {
      const int row = number[Index(static_cast<int>(it.row()))];
      if (row >= 0) part.insertBack(row, number[Index(column)]) = it.value();
    }
  }
  part.finalize();
  return part;
}

// Solves the symmetric system with lower half A. `shift` is subtracted from the diagonal of the
// pressure equations before the factorisation: at nu = 0.5 they have none, and a small negative one
// makes the matrix quasi-definite, so that LDL^T exists in any order (Vanderbei, SIAM J. Optim. 5,
// 1995). Iterative refinement with A removes the effect of this change.
Eigen::MatrixXd SolveSymmetric(const Sparse& A, const Eigen::VectorXd& shift,
                               const Eigen::MatrixXd& right) {
  Sparse factored = A;
  for (int k = 0; k < A.rows(); ++k) {
    if (shift[k] != 0) factored.coeffRef(k, k) -= shift[k];
  }
  const Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::AMDOrdering<int>> solver(factored);
  if (solver.info() != Eigen::Success) {
    throw std::runtime_error("finite elements: the equations have no finite solution");
  }
  const auto symmetric = A.selfadjointView<Eigen::Lower>();
  Eigen::MatrixXd x = solver.solve(right);
  for (int k = 0; k < kRefinements; ++k) {
    const Eigen::MatrixXd correction = solver.solve(Eigen::MatrixXd(right - symmetric * x));
    x += correction;
    if (correction.norm() <= 1e-11 * x.norm()) break;
  }
  if (!x.allFinite())
    throw std::runtime_error("finite elements: the equations have no finite solution");
  return x;
}

}  // namespace

QuadraticMesh::QuadraticMesh(const TriangleMesh& mesh)
    : nodes(mesh.points), corner_count(static_cast<int>(mesh.points.size())) {
  triangles.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) triangles[t][i] = mesh.triangles[t][i];
  }
  const auto middle_of = [](std::size_t opposite) { return 3 + (opposite + 1) % 3; };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& v = mesh.triangles[t];
      const int behind = mesh.neighbours[t][i];
      // Skipped, because the neighbouring triangle has created the node already.
      if (behind >= 0 && Index(behind) < t) continue;
      const int node = static_cast<int>(nodes.size());
      nodes.push_back(0.5 * (nodes[Index(v[(i + 1) % 3])] + nodes[Index(v[(i + 2) % 3])]));
      triangles[t][middle_of(i)] = node;
      if (behind < 0) continue;
      const auto& back = mesh.neighbours[Index(behind)];
      const auto edge = static_cast<std::size_t>(
          std::find(back.begin(), back.end(), static_cast<int>(t)) - back.begin());
      triangles[Index(behind)][middle_of(edge)] = node;
    }
  }
  auto segment = mesh.boundary.begin();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (mesh.neighbours[t][i] >= 0) continue;
      boundary.push_back({{segment->a, triangles[t][middle_of(i)], segment->b}, segment->tag});
      ++segment;
    }
  }
}

ElasticSolution SolveElastic(const QuadraticMesh& mesh, const PlaneMaterial& material,
                             const Prescribed& prescribed, const Fields& values) {
  const Constants constants = ConstantsOf(material);
  const System system(mesh, constants);
  const Sparse K = system.Matrix();
  int count = 0;
  const std::vector<int> number = NumberUnknowns(system, prescribed, &count);

  const Eigen::Index cases = values.cols() / 2;
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(system.size(), cases);
  for (int k = 0; k < system.node_dofs(); ++k) {
    if (number[Index(k)] >= 0) continue;
    for (Eigen::Index c = 0; c < cases; ++c) u(k, c) = values(k / 2, 2 * c + k % 2);
  }
  const auto symmetric = K.selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd load = -(symmetric * u);
  Eigen::MatrixXd right(count, cases);
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(count);
  for (int k = 0; k < system.size(); ++k) {
    if (number[Index(k)] < 0) continue;
    right.row(number[Index(k)]) = load.row(k);
    if (k < system.node_dofs()) continue;
    shift[number[Index(k)]] = kPressureShift / constants.G * system.pressure_mass(k);
  }
  const Eigen::MatrixXd x = SolveSymmetric(FreePart(K, number, count), shift, right);
  for (int k = 0; k < system.size(); ++k) {
    if (number[Index(k)] >= 0) u.row(k) = x.row(number[Index(k)]);
  }
  const Eigen::MatrixXd force = symmetric * u;

  ElasticSolution solution{Fields(static_cast<Eigen::Index>(mesh.nodes.size()), 2 * cases),
                           Fields::Zero(static_cast<Eigen::Index>(mesh.nodes.size()), 2 * cases)};
  for (int k = 0; k < system.node_dofs(); ++k) {
    for (Eigen::Index c = 0; c < cases; ++c) {
      solution.displacement(k / 2, 2 * c + k % 2) = u(k, c);
      if (number[Index(k)] < 0) solution.reaction(k / 2, 2 * c + k % 2) = force(k, c);
    }
  }
  return solution;
}

}  // namespace palpate::simulation
