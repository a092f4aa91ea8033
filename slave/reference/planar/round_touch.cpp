#include "slave/reference/planar/round_touch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "slave/mesh/index.h"
#include "slave/reference/planar/patch_solution.h"

namespace palpate::simulation {
namespace {

constexpr double kPerWidth = 24;   // elements across the tool
constexpr double kMaxEdge = 0.15;  // largest element far from the tool, relative to the larger side
constexpr double kEdgeGrowth = 0.4;
constexpr double kSupportEnd = 0.0005;
// Element size at the ends of a straight face, relative to the face.
constexpr double kFaceEnd = 0.01;
constexpr int kRounds = 100;

// Returns uniform elements under the tool and small ones at the ends of supports.
SizeField SizesUnder(const TaggedOutline& outline, double width, bool is_flat) {
  SizeField sizes{kMaxEdge, kEdgeGrowth, {}};
  std::vector<int> tag_before(outline.points.size(), 0);
  for (const MeshSegment& s : outline.segments) tag_before[Index(s.b)] = s.tag;
  for (const MeshSegment& s : outline.segments) {
    const Eigen::Vector2d &a = outline.points[Index(s.a)], &b = outline.points[Index(s.b)];
    if ((s.tag & kPatch) != 0) {
      const double step = width / kPerWidth;
      const int pieces = static_cast<int>(std::ceil((b - a).norm() / step));
      for (int i = 0; i <= pieces; ++i) sizes.seeds.push_back({a + i * (b - a) / pieces, step});
      if (is_flat && (tag_before[Index(s.a)] & kPatch) == 0) {
        sizes.seeds.push_back({a, kFaceEnd * width});
      }
    } else if (is_flat && (tag_before[Index(s.a)] & kPatch) != 0) {
      sizes.seeds.push_back({a, kFaceEnd * width});
    } else if (const int before = tag_before[Index(s.a)];
               before != s.tag && (before & kPatch) == 0) {
      sizes.seeds.push_back({a, kSupportEnd});
    }
  }
  return sizes;
}

// Returns the unsupported nodes under the tool, in the mesh's order.
std::vector<int> NodesUnder(const QuadraticMesh& mesh) {
  std::vector<int> nodes;
  for (const auto& edge : mesh.boundary) {
    if ((edge.tag & kPatch) != 0) nodes.insert(nodes.end(), edge.node.begin(), edge.node.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

// Prescribes two unit displacements per node.
void Prescribe(const QuadraticMesh& mesh, const std::vector<int>& nodes, Prescribed& prescribed,
               Fields& values) {
  const auto count = static_cast<Eigen::Index>(mesh.nodes.size());
  prescribed = Prescribed::Constant(count, 2, false);
  values = Fields::Zero(count, 4 * static_cast<Eigen::Index>(nodes.size()));
  for (const auto& edge : mesh.boundary) {
    if ((edge.tag & kHeld) == 0) continue;
    for (const int n : edge.node) prescribed.row(n).setConstant(true);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto first = 4 * static_cast<Eigen::Index>(i);
    prescribed.row(nodes[i]).setConstant(true);
    values(nodes[i], first) = values(nodes[i], first + 3) = 1;
  }
}

Eigen::MatrixXd Condensed(const ElasticSolution& solution, const std::vector<int>& nodes) {
  const auto size = 2 * static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd K(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index c = 0; c < size; ++c) {
      K(i, c) = solution.reaction(nodes[static_cast<std::size_t>(i / 2)], 2 * c + i % 2);
    }
  }
  return K;
}

}  // namespace

PatchSolution SolveUnderRound(const TrueBody& body, double poisson_ratio, Plane plane,
                              const BoundaryPlace& place, const Tool& tool) {
  const double unit = body.larger_side();
  const auto patch = body.Patch(place, tool.width);
  const TaggedOutline outline = Divide(body, place.loop, patch, unit);
  const SizeField sizes =
      SizesUnder(outline, (patch.second - patch.first) / unit, tool.radius == 0);
  PatchSolution solution{
      .mesh = QuadraticMesh(MakeGradedMesh(outline.points, outline.segments, sizes))};
  const std::vector<int> nodes = NodesUnder(solution.mesh);
  Prescribed prescribed;
  Fields values;
  Prescribe(solution.mesh, nodes, prescribed, values);
  ElasticSolution elastic =
      SolveElastic(solution.mesh, {1, poisson_ratio, plane}, prescribed, values);
  RoundTouch touch{Condensed(elastic, nodes), {}, place.normal_O, tool};
  for (const int n : nodes)
    touch.nodes.emplace_back(unit * solution.mesh.nodes[Index(n)] - place.p_O);
  solution.round = std::make_shared<const RoundTouch>(std::move(touch));
  solution.stiffness.setZero();
  solution.displacement = std::move(elastic.displacement);
  OrderBoundary(solution);
  return solution;
}

namespace {

// Returns the overlap of each node with the tool's surface without deformation [m].
Eigen::VectorXd Overlap(const RoundTouch& touch, const Eigen::Vector2d& moved, double turn) {
  Eigen::VectorXd overlap(static_cast<Eigen::Index>(touch.nodes.size()));
  const Eigen::Vector2d &n = touch.normal_O, along(-n.y(), n.x());
  const double radius = touch.tool.radius;
  for (Eigen::Index i = 0; i < overlap.size(); ++i) {
    const Eigen::Vector2d& p = touch.nodes[static_cast<std::size_t>(i)];
    // A round end has rolled away from the point that touched first.
    const double from_centre = p.dot(along) - radius * std::sin(turn);
    const double aside = std::min(std::abs(from_centre), radius);
    const double rise = radius > 0 ? radius - std::sqrt(radius * radius - aside * aside)
                                   : -p.dot(along) * std::tan(turn);
    overlap(i) = p.dot(n) - moved.dot(n) - rise;
  }
  return overlap;
}

// Returns the rows and columns of the touching nodes, or of the others.
std::vector<Eigen::Index> Components(const std::vector<char>& touches, bool which) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    if ((touches[i] != 0) != which) continue;
    rows.push_back(static_cast<Eigen::Index>(2 * i));
    rows.push_back(static_cast<Eigen::Index>(2 * i + 1));
  }
  return rows;
}

RoundState Balance(const Eigen::MatrixXd& K, const std::vector<char>& touches,
                   const Eigen::VectorXd& wanted) {
  const auto moved = Components(touches, true), free = Components(touches, false);
  RoundState state{Eigen::VectorXd::Zero(K.rows()), Eigen::VectorXd::Zero(K.rows())};
  state.displacement(moved) = wanted(moved);
  if (!free.empty()) {
    const Eigen::MatrixXd own = K(free, free);
    const Eigen::MatrixXd cross = K(free, moved);
    const Eigen::VectorXd by = wanted(moved), pushed = -(cross * by);
    const Eigen::VectorXd given = own.partialPivLu().solve(pushed);
    state.displacement(free) = given;
  }
  const Eigen::VectorXd force = K * state.displacement;
  state.force(moved) = force(moved);
  return state;
}

}  // namespace

RoundState Touched(const RoundTouch& touch, const Eigen::Vector2d& displacement_O, double turn) {
  const Eigen::VectorXd overlap = Overlap(touch, displacement_O, turn);
  const Eigen::Vector2d& n = touch.normal_O;
  const Eigen::Vector2d across = displacement_O - displacement_O.dot(n) * n;
  Eigen::VectorXd wanted(touch.stiffness.rows());
  for (Eigen::Index i = 0; i < overlap.size(); ++i) {
    wanted.segment<2>(2 * i) = across - overlap(i) * n;
  }
  std::vector<char> touches(touch.nodes.size());
  for (std::size_t i = 0; i < touches.size(); ++i) {
    touches[i] = overlap(static_cast<Eigen::Index>(i)) > 0 ? 1 : 0;
  }
  RoundState state;
  // Pulled nodes are released; nodes inside the tool begin to touch.
  for (int round = 0; round < kRounds; ++round) {
    state = Balance(touch.stiffness, touches, wanted);
    bool changed = false;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double behind = overlap(row) + state.displacement.segment<2>(2 * row).dot(n);
      const bool pulled = touches[i] != 0 && state.force.segment<2>(2 * row).dot(n) > 0;
      const bool passed =
          touches[i] == 0 && behind > 1e-9 * touch.tool.width && round < kRounds / 2;
      if (!pulled && !passed) continue;
      touches[i] = passed ? 1 : 0;
      changed = true;
    }
    if (!changed) break;
  }
  return state;
}

PatchSolution SecantAt(const PatchSolution& wide, const Eigen::Vector2d& displacement_O,
                       double turn) {
  const RoundState state = Touched(*wide.round, displacement_O, turn);
  PatchSolution at{.mesh = wide.mesh, .boundary = wide.boundary, .loop_begin = wide.loop_begin};
  const Eigen::Index nodes = wide.displacement.rows();
  Fields field = Fields::Zero(nodes, 2);
  for (Eigen::Index c = 0; c < state.displacement.size(); ++c) {
    if (state.displacement(c) == 0) continue;
    field += state.displacement(c) * wide.displacement.middleCols<2>(2 * c);
  }
  const Eigen::Vector2d share = displacement_O / displacement_O.squaredNorm();
  at.displacement.resize(nodes, 4);
  at.displacement.leftCols<2>() = share.x() * field;
  at.displacement.rightCols<2>() = share.y() * field;
  at.stiffness = state.total() * share.transpose();
  return at;
}

}  // namespace palpate::simulation
