#include "slave/mechanics/extruded/pressed_prism.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>
#include <Eigen/SparseCore>

#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mechanics/linear/sparse_ldlt.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Length of the elements at the tool's ends relative to its width, their growth per distance, and
// the largest length relative to the body's size. [tuned: 16 blocks compared with hexahedra, within
// 1.3 %]
constexpr double kAtTool = 0.25, kGrowth = 0.5, kMaxEdge = 0.25;
// Layers through the thickness: size of the first one at an end of the tool relative to the smaller
// of its extent and width, and growth of the layers. [tuned: the same]
constexpr double kFirstLayer = 0.35, kLayerGrowth = 3.2;
// Factors on both first sizes for an almost incompressible body. [tuned: the same, nu = 0.49]
constexpr double kFiner = 0.6, kAlmostIncompressible = 0.47;

// Excess width of the tool at each end, relative to the first element. [measured: blocks against
// two meshes of bricks, extrapolated; block_flat of presses.py]
constexpr double kExcess = 0.15;

double FinerFor(double nu) {
  return nu > kAlmostIncompressible ? kFiner : 1;
}

double SizeAtTool(const Prism& prism, double width) {
  return FinerFor(prism.poisson_ratio) * kAtTool * std::min(width, 2 * prism.depth);
}

double FirstLayer(double nu, double extent, double width) {
  return FinerFor(nu) * kFirstLayer * std::min(extent, width);
}

double SizeOf(const std::vector<Vector2d>& points) {
  Vector2d low = points.front(), high = low;
  for (const Vector2d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).maxCoeff();
}

// Chooses the element lengths along the tool: if its extent through the thickness is smaller than
// its width, the elements below it must be as short as the extent.
TriangleMesh MeshOf(const Prism& prism, const std::array<Vector2d, 2>& tool) {
  const double width = (tool[1] - tool[0]).norm();
  const double size = SizeAtTool(prism, width);
  SizeField sizes{kMaxEdge * SizeOf(prism.points), kGrowth, {}};
  const int pieces = std::max(1, static_cast<int>(std::lround(width / (4 * size))));
  for (int i = 0; i <= pieces; ++i) {
    sizes.seeds.push_back({tool[0] + (tool[1] - tool[0]) * i / pieces, size});
  }
  return MakeGradedMesh(prism.points, prism.segments, sizes);
}

// Quadratic triangles: corners, then the mid-edge nodes 01, 12, 20.
struct PlaneMesh {
  std::vector<Vector2d> nodes;
  std::vector<std::array<int, 6>> triangles;
  struct Edge {
    std::array<int, 3> nodes;  // ends a and b, mid-edge node
    int tag;
  };
  std::vector<Edge> boundary;

  explicit PlaneMesh(const TriangleMesh& mesh) : nodes(mesh.points) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [found, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<int>(nodes.size()));
      if (is_new) nodes.emplace_back(0.5 * (nodes[Index(a)] + nodes[Index(b)]));
      return found->second;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
      triangles.push_back({a, b, c, middle(a, b), middle(b, c), middle(c, a)});
    }
    for (const MeshSegment& s : mesh.boundary) {
      boundary.push_back({{s.a, s.b, middle(s.a, s.b)}, s.tag});
    }
  }
};

// Integrals of two shape functions of a plane mesh.
struct PlanePair {
  double mass = 0;
  Matrix2d stiffness = Matrix2d::Zero();  // (i, j): of d p / d i times d q / d j
  Vector2d left{0, 0}, right{0, 0};       // of d p / d i times q, and of p times d q / d i
};
// Per node p, the nodes q >= p that share a triangle with it.
using PlanePairs = std::vector<std::map<int, PlanePair>>;

struct TrianglePoint {
  std::array<double, 3> bary;
  double weight;
};
// Degree 4, six points (Strang and Fix 1973): exact for products of quadratic functions.
std::array<TrianglePoint, 6> TriangleRule() {
  constexpr double a = 0.445948490915965, b = 0.091576213509771;
  constexpr double wa = 0.223381589678011, wb = 0.109951743655322;
  return {{{{a, a, 1 - 2 * a}, wa},
           {{a, 1 - 2 * a, a}, wa},
           {{1 - 2 * a, a, a}, wa},
           {{b, b, 1 - 2 * b}, wb},
           {{b, 1 - 2 * b, b}, wb},
           {{1 - 2 * b, b, b}, wb}}};
}

PlanePairs PairsOf(const PlaneMesh& mesh) {
  constexpr std::array<std::array<std::size_t, 2>, 3> kEdges{{{0, 1}, {1, 2}, {2, 0}}};
  PlanePairs pairs(mesh.nodes.size());
  for (const auto& triangle : mesh.triangles) {
    Matrix3d corners;  // columns: 1, x, y
    for (int i = 0; i < 3; ++i) {
      corners.col(i) << 1, mesh.nodes[Index(triangle[Index(i)])];
    }
    const Matrix3d inverse = corners.inverse();
    const double area = corners.determinant() / 2;
    for (const auto& [bary, weight] : TriangleRule()) {
      std::array<double, 6> value{};
      std::array<Vector2d, 6> slope;
      const auto gradient = [&](std::size_t i) -> Vector2d {
        return inverse.row(static_cast<int>(i)).tail<2>().transpose();
      };
      for (std::size_t i = 0; i < 3; ++i) {
        value[i] = bary[i] * (2 * bary[i] - 1);
        slope[i] = (4 * bary[i] - 1) * gradient(i);
        const auto [a, b] = kEdges[i];
        value[3 + i] = 4 * bary[a] * bary[b];
        slope[3 + i] = 4 * (bary[a] * gradient(b) + bary[b] * gradient(a));
      }
      for (std::size_t p = 0; p < 6; ++p) {
        for (std::size_t q = 0; q < 6; ++q) {
          if (triangle[q] < triangle[p]) continue;
          PlanePair& pair = pairs[Index(triangle[p])][triangle[q]];
          const double w = weight * area;
          pair.mass += w * value[p] * value[q];
          pair.stiffness += w * slope[p] * slope[q].transpose();
          pair.left += w * value[q] * slope[p];
          pair.right += w * value[p] * slope[q];
        }
      }
    }
  }
  return pairs;
}

// Levels of the nodes through the thickness, from the front, and integrals of their functions.
struct Layers {
  std::vector<double> z;
  bool is_half = false;             // the last level is the plane of symmetry
  Eigen::MatrixXd mass, stiffness;  // of products of functions, and of their slopes
  Eigen::MatrixXd slope;            // (i, j): of function i times the slope of function j

  [[nodiscard]] int count() const { return static_cast<int>(z.size()); }
  void Integrate();
};

void Layers::Integrate() {
  const int n = count();
  mass = stiffness = slope = Eigen::MatrixXd::Zero(n, n);
  const double g = std::sqrt(0.6);
  constexpr std::array kWeights{5.0 / 9, 8.0 / 9, 5.0 / 9};
  const std::array<double, 3> points{-g, 0, g};
  for (int first = 0; first + 2 < n; first += 2) {
    const double half = (z[Index(first + 2)] - z[Index(first)]) / 2;
    for (std::size_t k = 0; k < 3; ++k) {
      const double s = points[k], w = kWeights[k] * half;
      const Vector3d value(s * (s - 1) / 2, 1 - s * s, s * (s + 1) / 2);
      const Vector3d by_z = Vector3d(s - 0.5, -2 * s, s + 0.5) / half;
      mass.block<3, 3>(first, first) += w * value * value.transpose();
      stiffness.block<3, 3>(first, first) += w * by_z * by_z.transpose();
      slope.block<3, 3>(first, first) += w * value * by_z.transpose();
    }
  }
}

// Returns the layer boundaries along a length; the tool ends at 0.
std::vector<double> GrowingFrom(double first, double length) {
  std::vector<double> ends{0};
  double h = first;
  while (ends.back() + 1.4 * h < length) {
    ends.push_back(ends.back() + h);
    h *= kLayerGrowth;
  }
  ends.push_back(length);
  return ends;
}

Layers LayersOf(const Prism& prism, double width) {
  Layers layers;
  const double T = prism.thickness, near = 1e-6 * T;
  const double low = std::max(prism.front, 0.0), high = std::min(prism.front + prism.depth, T);
  const double middle = (low + high) / 2;
  layers.is_half = std::abs(middle - T / 2) < near;
  const double first = FirstLayer(prism.poisson_ratio, high - low, width);
  std::vector<double> ends;
  if (low > near) {
    const auto grown = GrowingFrom(first, low);
    for (auto end = grown.rbegin(); end != grown.rend(); ++end) ends.push_back(low - *end);
  } else {
    ends.push_back(0);
  }
  for (const double end : GrowingFrom(first, middle - ends.back())) {
    if (end > 0) ends.push_back(std::max(low, 0.0) + end);
  }
  if (!layers.is_half) {
    const auto grown = GrowingFrom(first, high - middle);
    for (auto end = grown.rbegin() + 1; end != grown.rend(); ++end) ends.push_back(high - *end);
    if (high < T - near) {
      for (const double end : GrowingFrom(first, T - high)) {
        if (end > 0) ends.push_back(high + end);
      }
    }
  }
  layers.z.push_back(ends.front());
  for (std::size_t i = 1; i < ends.size(); ++i) {
    layers.z.push_back((ends[i - 1] + ends[i]) / 2);
    layers.z.push_back(ends[i]);
  }
  layers.Integrate();
  return layers;
}

// Numbers of the unknowns.
class Unknowns {
 public:
  enum : int { kHeld = -1, kMoved = -2 };  // fixed by a support; moved with the tool

  Unknowns(const PlaneMesh& mesh, const Layers& layers, const Prism& prism)
      : levels_(layers.count()), row_(3 * mesh.nodes.size() * Index(levels_), 0) {
    const double near = 1e-6 * prism.thickness;
    for (const PlaneMesh::Edge& edge : mesh.boundary) {
      for (const int node : edge.nodes) {
        for (int level = 0; level < levels_; ++level) {
          const double z = layers.z[Index(level)];
          const bool is_under = (edge.tag & Prism::kTool) != 0 && z > prism.front - near &&
                                z < prism.front + prism.depth + near;
          if (is_under) Move(node, level);
          if ((edge.tag & Prism::kHeld) == 0) continue;
          for (int c = 0; c < 3; ++c) at(node, level, c) = kHeld;
        }
      }
    }
    if (!layers.is_half) return;
    for (int node = 0; node < static_cast<int>(mesh.nodes.size()); ++node) {
      at(node, levels_ - 1, 2) = kHeld;
    }
  }

  void Number(const std::vector<int>& order) {
    for (const int node : order) {
      for (int level = 0; level < levels_; ++level) {
        for (int c = 0; c < 3; ++c) {
          if (at(node, level, c) >= 0) at(node, level, c) = count_++;
        }
      }
    }
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int& at(int node, int level, int component) {
    return row_[3 * (Index(node) * Index(levels_) + Index(level)) + Index(component)];
  }

 private:
  void Move(int node, int level) {
    for (int c = 0; c < 2; ++c) at(node, level, c) = kMoved;
    at(node, level, 2) = kHeld;
  }

  int levels_;
  std::vector<int> row_;
  int count_ = 0;
};

std::vector<int> OrderOf(const PlanePairs& pairs) {
  std::vector<std::vector<int>> neighbours(pairs.size());
  for (int p = 0; p < static_cast<int>(pairs.size()); ++p) {
    for (const auto& [q, pair] : pairs[Index(p)]) {
      neighbours[Index(p)].push_back(q);
      if (q != p) neighbours[Index(q)].push_back(p);
    }
  }
  return EliminationOrder(neighbours);
}

// The block between nodes p, i and q, j for E = 1.
class Stiffness {
 public:
  Stiffness(const Layers& layers, double nu)
      : layers_(layers), lambda_(nu / ((1 + nu) * (1 - 2 * nu))), mu_(0.5 / (1 + nu)) {}

  [[nodiscard]] Matrix3d Block(const PlanePair& pair, int i, int j) const {
    const double m = layers_.mass(i, j), k = layers_.stiffness(i, j);
    const double s = layers_.slope(i, j), t = layers_.slope(j, i);
    const double across = mu_ * (m * pair.stiffness.trace() + k * pair.mass);
    Matrix3d block;
    block.topLeftCorner<2, 2>() = m * (lambda_ * pair.stiffness + mu_ * pair.stiffness.transpose());
    block.topRightCorner<2, 1>() = lambda_ * s * pair.left + mu_ * t * pair.right;
    block.bottomLeftCorner<1, 2>() = (lambda_ * t * pair.right + mu_ * s * pair.left).transpose();
    block(2, 2) = (lambda_ + mu_) * k * pair.mass;
    block.diagonal().array() += across;
    return block;
  }

 private:
  const Layers& layers_;
  double lambda_, mu_;
};

// The system of the free unknowns, and its right-hand sides for tool motion along x and y.
struct System {
  Eigen::SparseMatrix<double> upper;
  Eigen::MatrixXd right;               // minus the forces of a unit motion of the tool
  Matrix2d direct = Matrix2d::Zero();  // force of the tool if all other nodes were fixed

  System(const PlanePairs& pairs, const Layers& layers, const Stiffness& stiffness, Unknowns* rows);

 private:
  void Add(int row, int column, int c, int d, double value);
  std::vector<Eigen::Triplet<double>> entries_;
};

void System::Add(int row, int column, int c, int d, double value) {
  if (row == Unknowns::kHeld || column == Unknowns::kHeld) return;
  if (row >= 0 && column >= 0) {
    if (row <= column) entries_.emplace_back(row, column, value);
  } else if (row >= 0) {
    right(row, d) -= value;
  } else if (column == Unknowns::kMoved) {
    direct(c, d) += value;
  }
}

System::System(const PlanePairs& pairs, const Layers& layers, const Stiffness& stiffness,
               Unknowns* rows)
    : right(Eigen::MatrixXd::Zero(rows->count(), 2)) {
  const int levels = layers.count();
  entries_.reserve(Index(rows->count()) * 60);
  for (int p = 0; p < static_cast<int>(pairs.size()); ++p) {
    for (const auto& [q, pair] : pairs[Index(p)]) {
      for (int i = 0; i < levels; ++i) {
        for (int j = std::max(0, i - 2); j < std::min(levels, i + 3); ++j) {
          if (layers.mass(i, j) == 0) continue;
          const Matrix3d block = stiffness.Block(pair, i, j);
          for (int c = 0; c < 3; ++c) {
            for (int d = 0; d < 3; ++d) {
              const int row = rows->at(p, i, c), column = rows->at(q, j, d);
              Add(row, column, c, d, block(c, d));
              if (q != p) Add(column, row, d, c, block(c, d));
            }
          }
        }
      }
    }
  }
  upper.resize(rows->count(), rows->count());
  upper.setFromTriplets(entries_.begin(), entries_.end());
  entries_ = {};
}

// The displacement of one node by the tool's motion along `axis`.
Vector3d MotionOf(Unknowns* rows, const Eigen::MatrixXd& x, int node, int axis) {
  Vector3d u;
  for (int c = 0; c < 3; ++c) {
    const int row = rows->at(node, 0, c);
    u[c] = row >= 0 ? x(row, axis) : row == Unknowns::kMoved && c == axis ? 1 : 0;
  }
  u.z() *= -1;  // because levels count from the front
  return u;
}

// The six nodes of the triangle at a place, and the values of their shape functions there.
struct PlaceInTriangle {
  std::array<int, 6> nodes{};
  std::array<double, 6> shapes{};
};

PlaceInTriangle FindPlace(const PlaneMesh& mesh, const Vector2d& p) {
  PlaceInTriangle place;
  double best = -std::numeric_limits<double>::infinity();
  for (const auto& nodes : mesh.triangles) {
    const Vector2d &a = mesh.nodes[Index(nodes[0])], &b = mesh.nodes[Index(nodes[1])],
                   &c = mesh.nodes[Index(nodes[2])];
    const double area = Orientation(a, b, c);
    const double l0 = Orientation(p, b, c) / area, l1 = Orientation(a, p, c) / area;
    const double l2 = 1 - l0 - l1, least = std::min({l0, l1, l2});
    if (least <= best) continue;
    best = least;
    place = {nodes,
             {l0 * (2 * l0 - 1), l1 * (2 * l1 - 1), l2 * (2 * l2 - 1), 4 * l0 * l1, 4 * l1 * l2,
              4 * l2 * l0}};
  }
  return place;
}

}  // namespace

EndExcess ExcessOf(const Prism& prism, double width) {
  return {kExcess * SizeAtTool(prism, width),
          kExcess * FirstLayer(prism.poisson_ratio, prism.depth, width)};
}

PressedPrism PressPrism(const Prism& prism, const std::array<Vector2d, 2>& tool,
                        const std::vector<Vector2d>& places) {
  const PlaneMesh mesh(MeshOf(prism, tool));
  const Layers layers = LayersOf(prism, (tool[1] - tool[0]).norm());
  const PlanePairs pairs = PairsOf(mesh);
  Unknowns rows(mesh, layers, prism);
  rows.Number(OrderOf(pairs));
  System system(pairs, layers, Stiffness(layers, prism.poisson_ratio), &rows);
  SparseLdlt<double> factor(system.upper);
  factor.Allocate(system.upper);
  if (!factor.Factorize(system.upper, true)) {
    throw std::invalid_argument("the supports leave the body free to move");
  }
  Eigen::MatrixXd x = system.right;
  factor.Solve(x);
  PressedPrism pressed;
  pressed.stiffness = system.direct - system.right.transpose() * x;
  if (layers.is_half) pressed.stiffness *= 2;
  for (const Vector2d& p : places) {
    const auto [nodes, shapes] = FindPlace(mesh, p);
    for (int axis = 0; axis < 2; ++axis) {
      Vector3d u = Vector3d::Zero();
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        u += shapes[i] * MotionOf(&rows, x, nodes[i], axis);
      }
      pressed.front[Index(axis)].push_back(u);
    }
  }
  pressed.unknowns = rows.count();
  pressed.elements = static_cast<int>(mesh.triangles.size()) * (layers.count() / 2);
  return pressed;
}

}  // namespace palpate
