#include "slave/reference/planar/patch_solution.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/mesh/index.h"

namespace palpate::simulation {
namespace {

using Point = Eigen::Vector2d;

// Small elements where the boundary condition changes: the stress is singular there.
SizeField SizesFor(const TaggedOutline& outline, double width, const Fineness& fineness) {
  SizeField sizes{fineness.largest, fineness.growth, {}};
  std::vector<int> tag_before(outline.points.size(), 0);
  for (const MeshSegment& s : outline.segments) tag_before[Index(s.b)] = s.tag;
  for (const MeshSegment& s : outline.segments) {
    const int before = tag_before[Index(s.a)];
    const Point& place = outline.points[Index(s.a)];
    if ((before & kPatch) != (s.tag & kPatch)) {
      sizes.seeds.push_back({place, fineness.at_patch_end * width});
    } else if (before != s.tag) {
      sizes.seeds.push_back({place, fineness.at_support_end});
    }
  }
  return sizes;
}

QuadraticMesh MeshUnder(const TrueBody& body, const BoundaryPlace& place, double width,
                        const Fineness& fineness) {
  const double unit = body.larger_side();
  const auto patch = body.Patch(place, width);
  const TaggedOutline outline = Divide(body, place.loop, patch, unit);
  const SizeField sizes = SizesFor(outline, (patch.second - patch.first) / unit, fineness);
  return QuadraticMesh(MakeGradedMesh(outline.points, outline.segments, sizes));
}

// The patch's nodes have the same displacement, also where the patch meets a support.
void Prescribe(const QuadraticMesh& mesh, Prescribed& prescribed, Fields& values) {
  const auto nodes = static_cast<Eigen::Index>(mesh.nodes.size());
  prescribed = Prescribed::Constant(nodes, 2, false);
  values = Fields::Zero(nodes, 4);
  for (const auto& edge : mesh.boundary) {
    for (const int n : edge.node) {
      if (edge.tag != 0) prescribed.row(n).setConstant(true);
      if ((edge.tag & kPatch) != 0) values.row(n) << 1, 0, 0, 1;
    }
  }
}

// Force of the tool per unit displacement: the reactions of the nodes that move with it.
Eigen::Matrix2d Stiffness(const ElasticSolution& solution, const Fields& values) {
  Eigen::Matrix2d K = Eigen::Matrix2d::Zero();
  for (Eigen::Index n = 0; n < values.rows(); ++n) {
    if (values(n, 0) == 0) continue;
    K.col(0) += solution.reaction.row(n).head<2>().transpose();
    K.col(1) += solution.reaction.row(n).tail<2>().transpose();
  }
  return K;
}

}  // namespace

// Boundary nodes in order, every loop starting where its first edge was found.
void OrderBoundary(PatchSolution& solution) {
  const auto& edges = solution.mesh.boundary;
  std::vector<int> edge_from(solution.mesh.nodes.size(), -1);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    edge_from[Index(edges[i].node[0])] = static_cast<int>(i);
  }
  std::vector<char> taken(edges.size(), 0);
  for (std::size_t start = 0; start < edges.size(); ++start) {
    if (taken[start] != 0) continue;
    solution.loop_begin.push_back(solution.boundary.size());
    for (std::size_t i = start; taken[i] == 0;) {
      taken[i] = 1;
      solution.boundary.push_back(edges[i].node[0]);
      solution.boundary.push_back(edges[i].node[1]);
      i = static_cast<std::size_t>(edge_from[static_cast<std::size_t>(edges[i].node[2])]);
    }
  }
  solution.loop_begin.push_back(solution.boundary.size());
}

PatchSolution SolvePatch(const TrueBody& body, double poisson_ratio, Plane plane,
                         const BoundaryPlace& place, double width, const Fineness& fineness) {
  PatchSolution solution{.mesh = MeshUnder(body, place, width, fineness)};
  Prescribed prescribed;
  Fields values;
  Prescribe(solution.mesh, prescribed, values);
  ElasticSolution elastic =
      SolveElastic(solution.mesh, {1, poisson_ratio, plane}, prescribed, values);
  solution.stiffness = Stiffness(elastic, values);
  solution.displacement = std::move(elastic.displacement);
  OrderBoundary(solution);
  return solution;
}

// Computes in a frame whose y axis is the direction of motion.
double SlidingStiffness(const TrueBody& body, double poisson_ratio, Plane plane,
                        const BoundaryPlace& place, double width, const Eigen::Vector2d& way_O,
                        const Fineness& fineness) {
  QuadraticMesh mesh = MeshUnder(body, place, width, fineness);
  Eigen::Matrix2d R_WO;
  R_WO << way_O.y(), -way_O.x(), way_O.x(), way_O.y();
  for (Point& p : mesh.nodes) p = R_WO * p;
  const auto nodes = static_cast<Eigen::Index>(mesh.nodes.size());
  Prescribed prescribed = Prescribed::Constant(nodes, 2, false);
  Fields values = Fields::Zero(nodes, 2);
  for (const auto& edge : mesh.boundary) {
    for (const int n : edge.node) {
      if ((edge.tag & kHeld) != 0) prescribed.row(n).setConstant(true);
      if ((edge.tag & kPatch) != 0) prescribed(n, 1) = true, values(n, 1) = 1;
    }
  }
  const auto solution = SolveElastic(mesh, {1, poisson_ratio, plane}, prescribed, values);
  return solution.reaction.col(1).dot(values.col(1));
}

TaggedOutline Divide(const TrueBody& body, int loop, std::pair<double, double> patch, double unit) {
  TaggedOutline outline;
  const double length = body.loop_length(loop), tolerance = 1e-9 * body.larger_side();
  const auto shifted = [&](double s, double after) {  // smallest s + k length above `after`
    return s + length * std::ceil((after - s) / length);
  };
  std::size_t loop_start = 0;
  const auto& edges = body.edges();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const TrueBody::Edge& e = edges[i];
    std::vector<double> cuts{0};
    for (const double end : {patch.first, patch.second}) {
      const double at = shifted(end, e.s) - e.s;
      if (e.loop == loop && at > tolerance && at < e.length() - tolerance) cuts.push_back(at);
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.push_back(e.length());
    const int held = e.is_held ? kHeld : 0;
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const double middle = e.s + 0.5 * (cuts[c] + cuts[c + 1]);
      const bool touched = e.loop == loop && shifted(middle, patch.first) < patch.second;
      const int number = static_cast<int>(outline.points.size());
      outline.points.push_back((e.a + cuts[c] / e.length() * (e.b - e.a)) / unit);
      outline.segments.push_back({number, number + 1, held | (touched ? kPatch : 0)});
    }
    if (i + 1 == edges.size() || edges[i + 1].loop != e.loop) {
      outline.segments.back().b = static_cast<int>(loop_start);
      loop_start = outline.points.size();
    }
  }
  return outline;
}

}  // namespace palpate::simulation
