#include "slave/reference/planar/true_body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate::simulation {
namespace {

using Point = Eigen::Vector2d;

constexpr double kCornerCosine = 0.866;  // a bend of 30 degrees ends a patch

Outline TrueOutline(const Scene& scene) {
  const Geometry& geometry = scene.object.geometry;
  if (std::holds_alternative<ImageContourGeometry>(geometry)) {
    const auto& embryo = scene.site.embryo;
    if (embryo && embryo->radius > 0) return OutlineOf(DiscGeometry{embryo->radius, 1});
    throw std::invalid_argument(
        "object.geometry.contour = from-image: the simulator expects an outline it can "
        "draw: rectangle, disc, polygon or a contour file");
  }
  return OutlineOf(geometry);
}

double LoopArea(const std::vector<Point>& loop) {
  double twice = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    twice += Cross(loop[i], loop[(i + 1) % loop.size()]);
  return twice / 2;
}

Eigen::Isometry2d InPlane(const Eigen::Isometry3d& X_SO, const Point& misplacement) {
  if (std::abs(X_SO.linear()(2, 2) - 1) > 1e-9) {
    throw std::invalid_argument(
        "object.pose.rotation: the simulator expects a rotation about z alone");
  }
  Eigen::Isometry2d X = Eigen::Isometry2d::Identity();
  X.linear() = X_SO.linear().topLeftCorner<2, 2>();
  X.translation() = X_SO.translation().head<2>() + misplacement;
  return X;
}

// Returns the angle about the origin of O relative to the direction `zero`, between -pi and pi.
double AngleFrom(const Point& p, double zero) {
  return std::remainder(std::atan2(p.y(), p.x()) - zero, 2 * std::numbers::pi);
}

}  // namespace

TrueBody::TrueBody(const Scene& scene)
    : X_SO_(InPlane(scene.object.X_SO, scene.site.misplacement)) {
  const Outline outline = TrueOutline(scene);
  loop_begin_ = {0};
  AddLoop(outline.outer, true);
  for (const auto& hole : outline.holes) AddLoop(hole, false);
  lower_ = upper_ = edges_.front().a;
  for (const Edge& e : edges_) {
    lower_ = lower_.cwiseMin(e.a);
    upper_ = upper_.cwiseMax(e.a);
  }
  larger_side_ = (upper_ - lower_).maxCoeff();
  SplitAtArcs(scene.object.fixed);
  for (const Fixed& fixed : scene.object.fixed) Hold(fixed);
  if (std::none_of(edges_.begin(), edges_.end(), [](const Edge& e) { return e.is_held; })) {
    throw std::invalid_argument(
        "object.fixed: contains no part of the boundary; the simulator expects a side, an "
        "arc or a plane that does");
  }
}

void TrueBody::AddLoop(std::vector<Point> loop, bool counter_clockwise) {
  const double area = LoopArea(loop);
  if (loop.size() < 3 || !(std::abs(area) > 0) || !std::isfinite(area)) {
    throw std::invalid_argument("object.geometry: a loop of the outline has no area");
  }
  if ((area > 0) != counter_clockwise) std::reverse(loop.begin(), loop.end());
  const int number = static_cast<int>(loop_begin_.size()) - 1;
  double s = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Edge edge{.loop = number, .s = s, .a = loop[i], .b = loop[(i + 1) % loop.size()]};
    if (edge.length() == 0) continue;
    edges_.push_back(edge);
    s += edge.length();
  }
  loop_begin_.push_back(edges_.size());
}

// Edges of the outer loop are divided where an arc begins or ends.
void TrueBody::SplitAtArcs(const std::vector<Fixed>& fixed) {
  for (const Fixed& f : fixed) {
    const auto* arc = std::get_if<FixedArc>(&f.where);
    if (arc == nullptr) continue;
    for (const double end : {arc->centre - arc->half_angle, arc->centre + arc->half_angle}) {
      const Point ray(std::cos(end), std::sin(end));
      for (std::size_t i = 0; i < loop_begin_[1]; ++i) {
        Edge& edge = edges_[i];
        const double from = Cross(ray, edge.a), to = Cross(ray, edge.b);
        const double where = from / (from - to);
        if (!(where > 1e-6 && where < 1 - 1e-6)) continue;
        const Point cut = edge.a + where * (edge.b - edge.a);
        if (ray.dot(cut) <= 0) continue;
        Edge rest = edge;
        rest.a = cut;
        rest.s = edge.s + where * edge.length();
        edge.b = cut;
        edges_.insert(edges_.begin() + static_cast<std::ptrdiff_t>(i) + 1, rest);
        for (std::size_t k = 1; k < loop_begin_.size(); ++k) ++loop_begin_[k];
        ++i;
      }
    }
  }
}

void TrueBody::Hold(const Fixed& fixed) {
  const double tolerance = 1e-6 * (upper_ - lower_).norm();
  const auto on_plane = [&](const Edge& e, int axis, double at) {
    return std::abs(e.a[axis] - at) <= tolerance && std::abs(e.b[axis] - at) <= tolerance;
  };
  const auto held = [&](const Edge& e) {
    if (const auto* side = std::get_if<FixedSide>(&fixed.where)) {
      if (side->side == "rim") return e.loop == 0;
      if (side->side == "left") return on_plane(e, 0, lower_.x());
      if (side->side == "right") return on_plane(e, 0, upper_.x());
      if (side->side == "bottom") return on_plane(e, 1, lower_.y());
      return side->side == "top" && on_plane(e, 1, upper_.y());
    }
    if (const auto* arc = std::get_if<FixedArc>(&fixed.where)) {
      const Point middle = 0.5 * (e.a + e.b);
      return e.loop == 0 && std::abs(AngleFrom(middle, arc->centre)) <= arc->half_angle;
    }
    if (const auto* plane = std::get_if<FixedPlane>(&fixed.where)) {
      return plane->axis < 2 && on_plane(e, plane->axis, plane->at);
    }
    throw std::invalid_argument(
        "object.fixed.nodes: the simulator expects a side, an arc or a plane; nodes belong "
        "to a model's mesh");
  };
  for (Edge& e : edges_) e.is_held = e.is_held || held(e);
}

double TrueBody::loop_length(int loop) const {
  const Edge& last = edges_[loop_begin_[static_cast<std::size_t>(loop) + 1] - 1];
  return last.s + last.length();
}

// Counts the edges that a ray to the right crosses; an odd number means inside.
bool TrueBody::Contains(const Point& p) const noexcept {
  bool inside = false;
  for (const Edge& e : edges_) {
    if ((e.a.y() > p.y()) == (e.b.y() > p.y())) continue;
    const double x = e.a.x() + (p.y() - e.a.y()) / (e.b.y() - e.a.y()) * (e.b.x() - e.a.x());
    inside = inside != (x > p.x());
  }
  return inside;
}

std::optional<BoundaryPlace> TrueBody::Entry(const Point& from, const Point& to) const noexcept {
  std::optional<BoundaryPlace> entry;
  double first = std::numeric_limits<double>::infinity();
  const Point way = to - from;
  for (const Edge& e : edges_) {
    const Point along = e.b - e.a;
    const double turn = Cross(way, along);
    if (!(turn < 0)) continue;  // inwards is to the left of the edge
    const double at_way = Cross(e.a - from, along) / turn;
    const double at_edge = Cross(e.a - from, way) / turn;
    if (!(at_way >= 0 && at_way <= 1 && at_edge >= 0 && at_edge <= 1) || at_way >= first) continue;
    first = at_way;
    entry = BoundaryPlace{e.loop, e.s + at_edge * e.length(), e.a + at_edge * along, e.normal()};
  }
  return entry;
}

BoundaryPlace TrueBody::Nearest(const Point& p) const noexcept {
  BoundaryPlace nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const Edge& e : edges_) {
    const Point along = e.b - e.a;
    const double t = std::clamp((p - e.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const Point q = e.a + t * along;
    const double distance = (p - q).squaredNorm();
    if (!(distance < least)) continue;
    least = distance;
    nearest = {e.loop, e.s + t * e.length(), q, e.normal()};
  }
  return nearest;
}

std::size_t TrueBody::EdgeAt(int loop, double s) const noexcept {
  const auto k = static_cast<std::size_t>(loop);
  std::size_t edge = loop_begin_[k];
  while (edge + 1 < loop_begin_[k + 1] && edges_[edge + 1].s <= s) ++edge;
  return edge;
}

BoundaryPlace TrueBody::PlaceAt(int loop, double s) const noexcept {
  const double length = loop_length(loop);
  s -= length * std::floor(s / length);
  const Edge& e = edges_[EdgeAt(loop, s)];
  const double t = std::clamp((s - e.s) / e.length(), 0.0, 1.0);
  return {loop, s, e.a + t * (e.b - e.a), e.normal()};
}

std::pair<double, double> TrueBody::Patch(const BoundaryPlace& place, double width) const {
  const auto k = static_cast<std::size_t>(place.loop);
  const std::size_t begin = loop_begin_[k], count = loop_begin_[k + 1] - begin;
  const double half = std::min(width / 2, 0.45 * loop_length(place.loop));
  const std::size_t home = EdgeAt(place.loop, place.s) - begin;
  const auto edge = [&](std::size_t i) -> const Edge& { return edges_[begin + i % count]; };
  const auto is_corner = [&](const Edge& before, const Edge& after) {
    return before.normal().dot(after.normal()) < kCornerCosine;
  };
  double to = edge(home).s + edge(home).length();
  for (std::size_t i = home; to < place.s + half; ++i) {
    if (is_corner(edge(i), edge(i + 1))) break;
    to += edge(i + 1).length();
  }
  double from = edge(home).s;
  for (std::size_t i = home + count; from > place.s - half; --i) {
    if (is_corner(edge(i - 1), edge(i))) break;
    from -= edge(i - 1).length();
  }
  return {std::max(from, place.s - half), std::min(to, place.s + half)};
}

}  // namespace palpate::simulation
