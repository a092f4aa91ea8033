#include "slave/mechanics/fem/green/tet_stiffness.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "shared/geometry/index.h"
#include "shared/geometry/symmetric_eigen.h"
#include "shared/mesh/mesh_census.h"
#include "shared/text/text.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kAssembly = 1;  // rises whenever the same inputs give another matrix
constexpr double kLargestNu = 0.499;
constexpr double kFixesMotion = 1e-10;  // smallest eigenvalue of the motions' Gram matrix

// The nodes of every element, corners first, and which components are held.
struct Elements {
  std::size_t per_element = 4;
  std::vector<std::array<int, 10>> nodes;
  HeldNodes held;
};

Elements Number(const SolidMesh& mesh, const HeldNodes& held, TetElement element) {
  Elements elements{element == TetElement::kTet4 ? 4U : 10U, {}, held};
  std::map<std::pair<int, int>, int> middles;
  for (const auto& tet : mesh.tets) {
    std::array<int, 10> nodes{};
    std::ranges::copy(tet, nodes.begin());
    if (element == TetElement::kTet10) {
      for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
        const int a = tet[Index(kTetEdges[e][0])], b = tet[Index(kTetEdges[e][1])];
        const auto [found, is_new] =
            middles.try_emplace(std::minmax(a, b), static_cast<int>(elements.held.size()));
        nodes[4 + e] = found->second;
        if (!is_new) continue;
        const auto &ha = held[Index(a)], &hb = held[Index(b)];
        elements.held.push_back({ha[0] && hb[0], ha[1] && hb[1], ha[2] && hb[2]});
      }
    }
    elements.nodes.push_back(nodes);
  }
  return elements;
}

// Gradients of the volume coordinates, one per corner.
Eigen::Matrix<double, 3, 4> CornerGradients(const std::array<Vector3d, 4>& p, double* volume) {
  Matrix3d edges;
  edges << p[1] - p[0], p[2] - p[0], p[3] - p[0];
  *volume = edges.determinant() / 6;
  Eigen::Matrix<double, 3, 4> gradients;
  gradients.rightCols<3>() = edges.inverse().transpose();
  gradients.col(0) = -gradients.rightCols<3>().rowwise().sum();
  return gradients;
}

using Gradients = Eigen::Matrix<double, 3, 10>;

// Of the quadratic shape functions l_i (2 l_i - 1) and 4 l_i l_j at volume coordinates `l`.
Gradients QuadraticGradients(const Eigen::Matrix<double, 3, 4>& g, const Eigen::Vector4d& l) {
  Gradients gradients;
  for (int i = 0; i < 4; ++i) gradients.col(i) = (4 * l[i] - 1) * g.col(i);
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[Index(e)];
    gradients.col(4 + e) = 4 * (l[i] * g.col(j) + l[j] * g.col(i));
  }
  return gradients;
}

using Stiffness = Eigen::Matrix<double, 30, 30>;

// k_ab += weight (lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) I)
void AddPoint(const Lame& lame, double weight, const Gradients& g, int count, Stiffness* k) {
  for (int b = 0; b < count; ++b) {
    for (int a = 0; a < count; ++a) {
      const Matrix3d outer = g.col(a) * g.col(b).transpose();
      Matrix3d block = lame.lambda * outer + lame.mu * outer.transpose();
      block.diagonal().array() += lame.mu * outer.trace();
      k->block<3, 3>(3 * a, 3 * b) += weight * block;
    }
  }
}

void ElementStiffness(const Lame& lame, const std::array<Vector3d, 4>& p, int count, Stiffness* k) {
  k->setZero();
  double volume = 0;
  const auto corners = CornerGradients(p, &volume);
  if (count == 4) {
    Gradients g = Gradients::Zero();
    g.leftCols<4>() = corners;
    AddPoint(lame, volume, g, count, k);
    return;
  }
  const double near = (5 + 3 * std::sqrt(5.0)) / 20, far = (5 - std::sqrt(5.0)) / 20;
  for (int q = 0; q < 4; ++q) {  // exact for quadratic integrands
    Eigen::Vector4d l = Eigen::Vector4d::Constant(far);
    l[q] = near;
    AddPoint(lame, volume / 4, QuadraticGradients(corners, l), count, k);
  }
}

// Throws unless the held components fix all six rigid motions of every connected part. O(N).
void RequireSupported(const SolidMesh& mesh, const HeldNodes& held) {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  int parts = 0;
  const std::vector<int> part = PartsOf(mesh.tets, mesh.nodes.size(), &parts);
  std::vector<Eigen::AlignedBox3d> box(Index(parts));
  for (std::size_t n = 0; n < part.size(); ++n) {
    if (part[n] >= 0) box[Index(part[n])].extend(mesh.nodes[n]);
  }
  std::vector<Matrix6d> gram(Index(parts), Matrix6d::Zero());
  for (std::size_t n = 0; n < part.size(); ++n) {
    if (part[n] < 0) continue;
    const auto& extent = box[Index(part[n])];
    const Vector3d r = (mesh.nodes[n] - extent.center()) / extent.sizes().maxCoeff();
    for (int c = 0; c < 3; ++c) {
      if (!held[n][Index(c)]) continue;
      Eigen::Matrix<double, 6, 1> mode;
      mode << Vector3d::Unit(c), r.cross(Vector3d::Unit(c));
      gram[Index(part[n])] += mode * mode.transpose();
    }
  }
  for (int p = 0; p < parts; ++p) {
    if (EigenOf(gram[Index(p)]).values[0] > kFixesMotion) continue;
    throw std::invalid_argument(
        "object.fixed: fem-green needs a fixed body: accepted are supports that prevent all six "
        "rigid motions of every part; the part with node " +
        std::to_string(std::ranges::find(part, p) - part.begin()) + " is free to move");
  }
}

// Zeros where elements join free components; rows rise in every column.
Eigen::SparseMatrix<double> LowerPattern(const Elements& elements,
                                         const std::vector<std::array<int, 3>>& row, int order) {
  std::vector<std::vector<int>> neighbours(row.size());
  for (const auto& nodes : elements.nodes) {
    for (std::size_t a = 0; a < elements.per_element; ++a) {
      for (std::size_t b = 0; b < elements.per_element; ++b) {
        if (nodes[b] >= nodes[a]) neighbours[Index(nodes[a])].push_back(nodes[b]);
      }
    }
  }
  for (auto& list : neighbours) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  Eigen::SparseMatrix<double> lower(order, order);
  std::size_t entries = 0;
  for (const auto& list : neighbours) entries += 9 * list.size();
  lower.reserve(static_cast<Eigen::Index>(entries));
  for (std::size_t a = 0; a < row.size(); ++a) {
    for (int c = 0; c < 3; ++c) {
      const int column = row[a][Index(c)];
      if (column < 0) continue;
      lower.startVec(column);
      for (const int b : neighbours[a]) {
        for (const int r : row[Index(b)]) {
          if (r >= column) lower.insertBackByOuterInner(column, r) = 0;
        }
      }
    }
  }
  lower.finalize();
  return lower;
}

int NumberRows(const Elements& elements, std::vector<std::array<int, 3>>* row) {
  std::vector<bool> used(elements.held.size(), false);
  for (const auto& nodes : elements.nodes) {
    for (std::size_t a = 0; a < elements.per_element; ++a) used[Index(nodes[a])] = true;
  }
  row->assign(elements.held.size(), {-1, -1, -1});
  int order = 0;
  for (std::size_t n = 0; n < row->size(); ++n) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (used[n] && !elements.held[n][c]) (*row)[n][c] = order++;
    }
  }
  return order;
}

void Scatter(const Stiffness& k, const std::array<int, 10>& nodes, std::size_t count,
             const std::vector<std::array<int, 3>>& row, Eigen::SparseMatrix<double>* lower) {
  for (std::size_t b = 0; b < 3 * count; ++b) {
    const int column = row[Index(nodes[b / 3])][b % 3];
    if (column < 0) continue;
    for (std::size_t a = 0; a < 3 * count; ++a) {
      const int r = row[Index(nodes[a / 3])][a % 3];
      if (r < column) continue;
      lower->coeffRef(r, column) += k(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    }
  }
}

std::uint64_t HashOf(const SolidMesh& mesh, const HeldNodes& held, double nu, TetElement element) {
  Hash hash;
  if (!mesh.modulus.empty()) hash.Add(std::as_bytes(std::span(mesh.modulus)));
  hash.Add(kAssembly).Add(element).Add(nu).Add(mesh.nodes.size()).Add(mesh.tets.size());
  hash.Add(std::as_bytes(std::span(mesh.nodes))).Add(std::as_bytes(std::span(mesh.tets)));
  return hash.Add(std::as_bytes(std::span(held))).value();
}

}  // namespace

TetStiffness AssembleTetStiffness(const SolidMesh& mesh, const HeldNodes& held, double nu,
                                  TetElement element) {
  if (!(nu > -1 && nu <= kLargestNu)) {
    RefuseValue("poisson_ratio", nu, "-1 < nu <= 0.499 (linear tetrahedra lock beyond)");
  }
  RequireTets(mesh, held);
  RequireSupported(mesh, held);
  const Elements elements = Number(mesh, held, element);
  TetStiffness stiffness;
  stiffness.inputs = HashOf(mesh, held, nu, element);
  stiffness.length_unit = LargerSide(mesh.nodes);
  const int order = NumberRows(elements, &stiffness.row);
  stiffness.lower = LowerPattern(elements, stiffness.row, order);
  const Lame body = LameOf(nu);
  Stiffness k;
  for (std::size_t t = 0; t < elements.nodes.size(); ++t) {
    const auto& nodes = elements.nodes[t];
    std::array<Vector3d, 4> p;
    for (std::size_t v = 0; v < 4; ++v) {
      p[v] = (mesh.nodes[Index(nodes[v])] - mesh.nodes.front()) / stiffness.length_unit;
    }
    const double modulus = mesh.ModulusOf(t);
    const Lame lame{modulus * body.mu, modulus * body.lambda};
    ElementStiffness(lame, p, static_cast<int>(elements.per_element), &k);
    Scatter(k, nodes, elements.per_element, stiffness.row, &stiffness.lower);
  }
  return stiffness;
}

}  // namespace palpate
