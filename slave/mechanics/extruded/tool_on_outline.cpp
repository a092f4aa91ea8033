#include "slave/mechanics/extruded/tool_on_outline.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kFlat = 1e-3;    // of the larger side, see PlaceTool
constexpr double kCorner = 0.87;  // cosine between neighbours' normals: 30 degrees [by definition]
// Distance from a vertex, relative to the tool's width, within which the tool ends at the vertex.
constexpr double kMeets = 1e-6;

int LoopOf(const BoundaryMesh& mesh, int element) {
  int loop = 0;
  while (mesh.loop_begin[Index(loop) + 1] <= element) ++loop;
  return loop;
}

int TagOf(const std::array<bool, 2>& held) {
  return held[0] && held[1] ? Prism::kHeld : 0;
}

// A vertex of the outline before segments are joined; its tag is that of the following segment.
struct Vertex {
  Vector2d p{0, 0};
  int tag = 0;
};

bool IsStraight(const std::vector<Vertex>& loop, std::size_t from, std::size_t to, double slack) {
  const Vector2d& a = loop[from].p;
  const Vector2d along = (loop[to % loop.size()].p - a).normalized();
  for (std::size_t k = from + 1; k < to; ++k) {
    if (std::abs(Cross(along, loop[k].p - a)) > slack) return false;
  }
  return true;
}

// Joins the elements of a loop, beginning where the tag changes, if it does.
void Join(std::vector<Vertex> loop, double slack, ToolOnOutline* outline) {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    if (loop[i].tag == loop[(i + 1) % loop.size()].tag) continue;
    std::ranges::rotate(loop, loop.begin() + static_cast<long>((i + 1) % loop.size()));
    break;
  }
  const auto first = static_cast<int>(outline->points.size());
  for (std::size_t from = 0; from < loop.size();) {
    std::size_t to = from + 1;
    // A loop keeps at least three segments.
    while (to < loop.size() && loop[to].tag == loop[from].tag && to - from < loop.size() / 3 &&
           IsStraight(loop, from, to + 1, slack)) {
      ++to;
    }
    const auto a = static_cast<int>(outline->points.size());
    outline->points.push_back(loop[from].p);
    outline->segments.push_back({a, to == loop.size() ? first : a + 1, loop[from].tag});
    from = to;
  }
}

// The part of a loop under a tool, as arc length from the tool's centre [m].
struct Reach {
  double before = 0, after = 0;
};
Reach ReachOf(const BoundaryMesh& mesh, int element, double on_element, double width) {
  const auto turns = [&](int a, int b) {
    return mesh.elements[Index(a)].normal().dot(mesh.elements[Index(b)].normal()) < kCorner;
  };
  const double half = width / 2;
  Reach reach{on_element, mesh.elements[Index(element)].length() - on_element};
  for (int e = element; reach.before < half;) {
    const int previous = mesh.Previous(e);
    if (turns(previous, e) || previous == element) break;
    reach.before += mesh.elements[Index(previous)].length();
    e = previous;
  }
  for (int e = element; reach.after < half;) {
    const int next = mesh.Next(e);
    if (turns(e, next) || next == element) break;
    reach.after += mesh.elements[Index(next)].length();
    e = next;
  }
  return {std::min(reach.before, half), std::min(reach.after, half)};
}

double OnElement(const BoundaryElement& element, const Vector2d& p_O) {
  const Vector2d along = (element.b - element.a).normalized();
  return std::clamp(along.dot(p_O - element.a), 0.0, element.length());
}

}  // namespace

std::optional<ToolOnOutline> PlaceTool(const BoundaryMesh& mesh,
                                       const std::vector<std::array<bool, 2>>& held, int element,
                                       const Vector2d& p_O, double width) {
  ToolOnOutline placed;
  const double on = OnElement(mesh.elements[Index(element)], p_O);
  const Reach reach = ReachOf(mesh, element, on, width);
  Eigen::AlignedBox2d box;
  for (const BoundaryElement& e : mesh.elements) box.extend(e.a);
  const double slack = kFlat * box.sizes().maxCoeff();
  const int own = LoopOf(mesh, element);
  for (int loop = 0; loop + 1 < static_cast<int>(mesh.loop_begin.size()); ++loop) {
    const int begin = mesh.loop_begin[Index(loop)], end = mesh.loop_begin[Index(loop) + 1];
    std::vector<Vertex> vertices;
    if (loop != own) {
      for (int e = begin; e < end; ++e) {
        vertices.push_back({mesh.elements[Index(e)].a, TagOf(held[Index(e)])});
      }
      Join(std::move(vertices), slack, &placed);
      continue;
    }
    // Begins at the tool's element, so that arc lengths refer to the tool's centre.
    double length = 0;
    for (int e = begin; e < end; ++e) length += mesh.elements[Index(e)].length();
    const std::array<double, 2> ends{reach.after, length - reach.before};
    double way = -on;
    for (int k = 0, e = element; k < end - begin; ++k, e = mesh.Next(e)) {
      const BoundaryElement& piece = mesh.elements[Index(e)];
      const int tag = TagOf(held[Index(e)]);
      std::vector<double> cuts{0};  // along this element
      for (std::size_t i = 0; i < 2; ++i) {
        double cut = ends[i] - way;
        if (k == 0 && i == 1) cut = on - reach.before;
        if (cut > kMeets * width && cut < piece.length() - kMeets * width) cuts.push_back(cut);
      }
      std::ranges::sort(cuts);
      for (std::size_t i = 0; i < cuts.size(); ++i) {
        const double next = i + 1 < cuts.size() ? cuts[i + 1] : piece.length();
        const double at = way + (cuts[i] + next) / 2;
        const bool covered = (at > -reach.before && at < reach.after) || at > ends[1];
        if (covered && tag != 0) return std::nullopt;
        vertices.push_back({piece.a + cuts[i] / piece.length() * (piece.b - piece.a),
                            covered ? Prism::kTool : tag});
      }
      way += piece.length();
    }
    const auto point = [&](bool at_begin) {
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        const Vertex& before = vertices[(i + vertices.size() - 1) % vertices.size()];
        const bool is_begin = vertices[i].tag == Prism::kTool && before.tag != Prism::kTool;
        const bool is_end = vertices[i].tag != Prism::kTool && before.tag == Prism::kTool;
        if (at_begin ? is_begin : is_end) return vertices[i].p;
      }
      return p_O;
    };
    placed.ends = {point(true), point(false)};
    Join(std::move(vertices), slack, &placed);
  }
  return placed;
}

}  // namespace palpate
