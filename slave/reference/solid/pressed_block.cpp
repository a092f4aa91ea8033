#include "slave/reference/solid/pressed_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SparseCore>

#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mechanics/linear/sparse_ldlt.h"
#include "slave/mesh/index.h"

namespace palpate::simulation {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Size of the first hexahedron at an end of the tool relative to the tool's smaller side, and
// growth of the hexahedra. [tuned: pressed_block_test, within 2 %]
constexpr double kFirstLayer = 0.2, kLayerGrowth = 2;
constexpr double kMaxNu = 0.4999;  // elements with displacements only would lock beyond it
// Excess width of the tool at each end, where the stress is singular, relative to the first
// hexahedron. [measured: as above]
constexpr double kExcess = 0.1;

// Returns the hexahedra's boundaries along one axis, fine at `low` and `high`, the ends of the
// tool.
std::vector<double> Ends(double length, double low, double high, double first) {
  const auto grown = [&](double from, double to) {
    std::vector<double> ends;
    const double way = std::abs(to - from), side = to > from ? 1 : -1;
    for (double at = first, h = first; at + 0.7 * h < way; h *= kLayerGrowth, at += h) {
      ends.push_back(from + side * at);
    }
    return ends;
  };
  const double near = 1e-9 * length, middle = (low + high) / 2;
  std::vector<double> ends{0, length, low, high, middle};
  for (const auto& part :
       {grown(low, 0), grown(high, length), grown(low, middle), grown(high, middle)}) {
    ends.insert(ends.end(), part.begin(), part.end());
  }
  for (double& end : ends) end = std::clamp(end, 0.0, length);
  std::ranges::sort(ends);
  ends.erase(
      std::unique(ends.begin(), ends.end(), [&](double a, double b) { return b - a < near; }),
      ends.end());
  return ends;
}

// Returns the nodes of quadratic hexahedra: ends and midpoints.
std::vector<double> NodesOf(const std::vector<double>& ends) {
  std::vector<double> nodes{ends.front()};
  for (std::size_t i = 1; i < ends.size(); ++i) {
    nodes.push_back((ends[i - 1] + ends[i]) / 2);
    nodes.push_back(ends[i]);
  }
  return nodes;
}

// Quadratic functions on [-1, 1] and their slopes.
struct Line {
  Vector3d value, slope;
  explicit Line(double s)
      : value(s * (s - 1) / 2, 1 - s * s, s * (s + 1) / 2), slope(s - 0.5, -2 * s, s + 0.5) {}
};

using BrickMatrix = Eigen::Matrix<double, 81, 81>;

BrickMatrix StiffnessOf(const Vector3d& size, double nu) {
  const double lambda = nu / ((1 + nu) * (1 - 2 * nu)), mu = 0.5 / (1 + nu);
  Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Zero();
  D.topLeftCorner<3, 3>().setConstant(lambda);
  D.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
  const double g = std::sqrt(0.6);
  const std::array<double, 3> points{-g, 0, g}, weights{5.0 / 9, 8.0 / 9, 5.0 / 9};
  BrickMatrix K = BrickMatrix::Zero();
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::array<Line, 3> lines{Line(points[a]), Line(points[b]), Line(points[c])};
        Eigen::Matrix<double, 6, 81> B = Eigen::Matrix<double, 6, 81>::Zero();
        for (int n = 0; n < 27; ++n) {
          const std::array<int, 3> at{n % 3, n / 3 % 3, n / 9};
          Vector3d slope;
          for (int axis = 0; axis < 3; ++axis) {
            double product = 2 / size[axis];
            for (int other = 0; other < 3; ++other) {
              const Line& line = lines[Index(other)];
              product *=
                  other == axis ? line.slope[at[Index(other)]] : line.value[at[Index(other)]];
            }
            slope[axis] = product;
          }
          for (int axis = 0; axis < 3; ++axis) B(axis, 3 * n + axis) = slope[axis];
          B(3, 3 * n) = B(4, 3 * n + 2) = slope.y();
          B(3, 3 * n + 1) = B(5, 3 * n + 2) = slope.x();
          B(4, 3 * n + 1) = B(5, 3 * n) = slope.z();
        }
        const double weight = weights[a] * weights[b] * weights[c] * size.prod() / 8;
        K.noalias() += weight * B.transpose() * D * B;
      }
    }
  }
  return K;
}

// The block in axes along the pressed side, into the body, and from the front to the back.
struct Grid {
  std::array<std::vector<double>, 3> nodes;  // along each axis
  [[nodiscard]] int size(int axis) const { return static_cast<int>(nodes[Index(axis)].size()); }
  [[nodiscard]] int count() const { return size(0) * size(1) * size(2); }
  [[nodiscard]] int node(int i, int j, int k) const { return i + size(0) * (j + size(1) * k); }
  [[nodiscard]] Vector3d at(int i, int j, int k) const {
    return {nodes[0][Index(i)], nodes[1][Index(j)], nodes[2][Index(k)]};
  }
};

struct Sides {
  std::array<TrueBody::Edge, 4> edge;  // the pressed one first, counter-clockwise
};

Sides SidesOf(const TrueBody& body, const BoundaryPlace& place) {
  const auto& edges = body.edges();
  if (edges.size() != 4) {
    throw std::invalid_argument(
        "object.geometry: the simulator presses a rectangle only by a tool that reaches through "
        "a part of the thickness");
  }
  std::size_t pressed = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (edges[i].normal().dot(place.normal_O) > edges[pressed].normal().dot(place.normal_O)) {
      pressed = i;
    }
  }
  Sides sides;
  for (std::size_t i = 0; i < 4; ++i) sides.edge[i] = edges[(pressed + i) % 4];
  if (sides.edge[0].is_held) {
    throw std::invalid_argument("object.fixed: the simulated tool presses a side that is held");
  }
  return sides;
}

enum : int { kHeld = -1, kMoved = -2 };  // instead of a row

struct Tooling {
  // Ends of the tool along the side and along the thickness.
  double low = 0, high = 0, front = 0, back = 0;
};

// Moves the ends of a tool on [0, length] inwards, except at the ends of the body.
void Narrow(double excess, double length, double* low, double* high) {
  const double near = 1e-6 * length;
  if (*low > near) *low += excess;
  if (*high < length - near) *high -= excess;
}

// Returns the row of the system for each component of each node.
std::vector<int> RowsOf(const Grid& grid, const Sides& sides, const Tooling& tool, int* count) {
  std::vector<int> rows(3 * Index(grid.count()), 0);
  const double near = 1e-9 * grid.nodes[0].back();
  const auto hold = [&](int node, const TrueBody::Edge& edge) {
    if (!edge.is_held) return;
    for (int c = 0; c < 3; ++c) rows[Index(3 * node + c)] = kHeld;
  };
  for (int k = 0; k < grid.size(2); ++k) {
    for (int j = 0; j < grid.size(1); ++j) {
      for (int i = 0; i < grid.size(0); ++i) {
        const int node = grid.node(i, j, k);
        const Vector3d p = grid.at(i, j, k);
        if (i + 1 == grid.size(0)) hold(node, sides.edge[1]);
        if (j + 1 == grid.size(1)) hold(node, sides.edge[2]);
        if (i == 0) hold(node, sides.edge[3]);
        const bool is_under = j == 0 && p.x() > tool.low - near && p.x() < tool.high + near &&
                              p.z() > tool.front - near && p.z() < tool.back + near;
        if (!is_under) continue;
        rows[Index(3 * node)] = rows[Index(3 * node + 1)] = kMoved;
        rows[Index(3 * node + 2)] = kHeld;
      }
    }
  }
  std::vector<std::vector<int>> neighbours(Index(grid.count()));
  for (int k = 0; k < grid.size(2); ++k) {
    for (int j = 0; j < grid.size(1); ++j) {
      for (int i = 0; i < grid.size(0); ++i) {
        // Hexahedra that contain a node: two at an end, one at a midpoint.
        const auto first = [](int n) { return n % 2 == 0 ? std::max(n - 2, 0) : n - 1; };
        const auto last = [](int n, int size) {
          return n % 2 == 0 ? std::min(n + 2, size - 1) : n + 1;
        };
        auto& own = neighbours[Index(grid.node(i, j, k))];
        for (int c = first(k); c <= last(k, grid.size(2)); ++c) {
          for (int b = first(j); b <= last(j, grid.size(1)); ++b) {
            for (int a = first(i); a <= last(i, grid.size(0)); ++a) {
              own.push_back(grid.node(a, b, c));
            }
          }
        }
      }
    }
  }
  *count = 0;
  for (const int node : EliminationOrder(neighbours)) {
    for (int c = 0; c < 3; ++c) {
      int& row = rows[Index(3 * node + c)];
      if (row >= 0) row = (*count)++;
    }
  }
  return rows;
}

// Returns the displacements, components of all nodes x 2 cases: the tool moves along the side, and
// into the body. `stiffness`: forces of the tool.
Eigen::MatrixXd SolveCases(const Grid& grid, const std::vector<int>& rows, int count, double nu,
                           Matrix2d* stiffness) {
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 2);
  std::vector<Eigen::Triplet<double>> entries;
  stiffness->setZero();
  for (int k = 0; k + 2 < grid.size(2); k += 2) {
    for (int j = 0; j + 2 < grid.size(1); j += 2) {
      for (int i = 0; i + 2 < grid.size(0); i += 2) {
        const BrickMatrix K = StiffnessOf(grid.at(i + 2, j + 2, k + 2) - grid.at(i, j, k), nu);
        std::array<int, 81> row{}, axis{};
        for (int n = 0; n < 27; ++n) {
          const int node = grid.node(i + n % 3, j + n / 3 % 3, k + n / 9);
          for (int c = 0; c < 3; ++c) {
            row[Index(3 * n + c)] = rows[Index(3 * node + c)];
            axis[Index(3 * n + c)] = c;
          }
        }
        for (int a = 0; a < 81; ++a) {
          for (int b = 0; b < 81; ++b) {
            const int r = row[Index(a)], c = row[Index(b)];
            if (r >= 0 && c >= r) entries.emplace_back(r, c, K(a, b));
            if (r >= 0 && c == kMoved) right(r, axis[Index(b)]) -= K(a, b);
            if (r == kMoved && c == kMoved) (*stiffness)(axis[Index(a)], axis[Index(b)]) += K(a, b);
          }
        }
      }
    }
  }
  Eigen::SparseMatrix<double> upper(count, count);
  upper.setFromTriplets(entries.begin(), entries.end());
  entries = {};
  SparseLdlt<double> factor(upper);
  factor.Allocate(upper);
  if (!factor.Factorize(upper, true)) {
    throw std::runtime_error("the block has no solution: its supports leave it free to move");
  }
  Eigen::MatrixXd x = right;
  factor.Solve(x);
  *stiffness -= right.transpose() * x;
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), 2);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto at = static_cast<Eigen::Index>(r);
    if (rows[r] >= 0) u.row(at) = x.row(rows[r]);
    if (rows[r] == kMoved) u(at, at % 3) = 1;
  }
  return u;
}

// The functions of one axis at a position: the first node and three values.
std::pair<int, Vector3d> FunctionsAt(const std::vector<double>& nodes, double x) {
  int first = 0;
  while (Index(first + 4) < nodes.size() && nodes[Index(first + 2)] < x) first += 2;
  const double low = nodes[Index(first)], high = nodes[Index(first + 2)];
  return {first, Line(std::clamp(2 * (x - low) / (high - low) - 1, -1.0, 1.0)).value};
}

}  // namespace

PatchSolution SolveBlock(const TrueBody& body, double poisson_ratio, double thickness,
                         const BoundaryPlace& place, const Tool& tool) {
  const Sides sides = SidesOf(body, place);
  PatchSolution solution = SolvePatch(body, poisson_ratio, Plane::kStress, place, tool.width);
  const double unit = body.larger_side(), nu = std::min(poisson_ratio, kMaxNu);
  const Vector2d corner = sides.edge[0].a, along = (sides.edge[0].b - corner).normalized();
  const Vector2d inward = -sides.edge[0].normal();
  Matrix2d to_O;
  to_O << along, inward;
  const auto patch = body.Patch(place, tool.width);
  const double begin = along.dot(place.p_O - corner) - place.s;
  const double front = tool.BehindFront(thickness);
  const double length = sides.edge[0].length() / unit, depth = sides.edge[1].length() / unit;
  Tooling tooling{(begin + patch.first) / unit, (begin + patch.second) / unit, front / unit,
                  (front + std::min(*tool.depth, thickness)) / unit};
  const double first =
      kFirstLayer * std::min(tooling.high - tooling.low, tooling.back - tooling.front);
  Narrow(kExcess * first, length, &tooling.low, &tooling.high);
  Narrow(kExcess * first, thickness / unit, &tooling.front, &tooling.back);
  Grid grid;
  grid.nodes = {NodesOf(Ends(length, tooling.low, tooling.high, first)),
                NodesOf(Ends(depth, 0, 0, first)),
                NodesOf(Ends(thickness / unit, tooling.front, tooling.back, first))};
  int count = 0;
  const std::vector<int> rows = RowsOf(grid, sides, tooling, &count);
  Matrix2d stiffness;
  const Eigen::MatrixXd u = SolveCases(grid, rows, count, nu, &stiffness);
  solution.stiffness = to_O * stiffness * to_O.transpose() * unit / thickness;
  for (std::size_t n = 0; n < solution.mesh.nodes.size(); ++n) {
    const Vector2d p = to_O.transpose() * (solution.mesh.nodes[n] - corner / unit);
    const auto [i, by_i] = FunctionsAt(grid.nodes[0], p.x());
    const auto [j, by_j] = FunctionsAt(grid.nodes[1], p.y());
    Matrix2d moved = Matrix2d::Zero();  // columns: cases
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        const auto row = Eigen::Index{3} * grid.node(i + a, j + b, 0);
        moved += by_i[a] * by_j[b] * u.block<2, 2>(row, 0);
      }
    }
    const Matrix2d moved_O = to_O * moved * to_O.transpose();
    solution.displacement.row(static_cast<Eigen::Index>(n)) << moved_O.col(0).transpose(),
        moved_O.col(1).transpose();
  }
  return solution;
}

}  // namespace palpate::simulation
