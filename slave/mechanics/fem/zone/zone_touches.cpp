#include "slave/mechanics/fem/zone/zone_touches.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kLeastRadius = 2.5;  // of a zone [edges]
constexpr double kMargin = 0.5;       // of a zone beyond that or the contact's width [edges]
constexpr double kZoneExtent = 1.3;   // of a zone's nodes from its centre [radii]
constexpr double kInside = 0.8;    // of touchable nodes from the border of a zone, at least [edges]
constexpr double kFollows = 1.01;  // distance of a tool from its zone's centre [edges]

std::vector<double> EdgesAround(const SurfaceMesh& surface) {
  std::vector<double> sum(surface.nodes.size(), 0), count(surface.nodes.size(), 0);
  for (const auto& triangle : surface.triangles) {
    for (std::size_t v = 0; v < 3; ++v) {
      const auto a = Index(triangle[v]), b = Index(triangle[(v + 1) % 3]);
      const double length = (surface.nodes[a] - surface.nodes[b]).norm();
      for (const std::size_t node : {a, b}) sum[node] += length, ++count[node];
    }
  }
  for (std::size_t n = 0; n < sum.size(); ++n) sum[n] /= std::max(1.0, count[n]);
  return sum;
}

// Mean of the triangles around, by their areas.
std::vector<Vector3d> NormalsAround(const SurfaceMesh& surface) {
  std::vector<Vector3d> normals(surface.nodes.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const int triangle = static_cast<int>(t);
    const Vector3d area = Area(surface, triangle) * Normal(surface, triangle);
    for (const int node : surface.triangles[t]) normals[Index(node)] += area;
  }
  for (Vector3d& normal : normals) {
    if (normal.norm() > 0) normal.normalize();
  }
  return normals;
}

bool IsAnyHeld(const std::array<bool, 3>& held) {
  return held[0] || held[1] || held[2];
}

}  // namespace

ZoneTouches::ZoneTouches(const SolidMesh& mesh, const HeldNodes& held, const Params& params)
    : mesh_(mesh),
      held_(held),
      params_(params),
      unit_(LargerSide(mesh.nodes)),
      surface_(SurfaceOf(mesh)),
      edge_(EdgesAround(surface_)),
      normal_(NormalsAround(surface_)) {}

int ZoneTouches::NodeNear(const Vector3d& p_O) const {
  const auto found = FindPlace(surface_, p_O);
  if (!found) return -1;
  if (found->node >= 0) return found->node;
  int nearest = 0;
  found->weights.maxCoeff(&nearest);
  return surface_.triangles[Index(found->triangle)][Index(nearest)];
}

// For the part of the surface that the tool may touch at such a depth: half its width, or where a
// sphere would cut the undeformed surface, which is farther out than it touches.
double ZoneTouches::ToolRadius(double width, double depth) const {
  const Tool& tool = params_.tool;
  if (tool.shape == Tool::Shape::kFlat) return 0.5 * width;
  const double capped = std::clamp(depth, 0.0, tool.radius);
  const double cut = std::sqrt(capped * (2 * tool.radius - capped));
  return cut + (tool.shape == Tool::Shape::kCapsule ? 0.5 * tool.length : 0);
}

void ZoneTouches::AddToolPoints(double edge, ZoneSet::Touch* touch) const {
  const Vector3d& normal = touch->contact.placement.normal;
  for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) {
    if (!(edge_[n] > 0) || normal_[n].dot(normal) <= 0 || IsAnyHeld(held_[n])) continue;
    if ((mesh_.nodes[n] - touch->centre_O).norm() > touch->radius - kInside * edge) continue;
    touch->contact.points.push_back({{static_cast<int>(touch->nodes.size()), 1.0}});
    touch->nodes.push_back(static_cast<int>(n));
  }
}

std::string_view ZoneTouches::MakeTool(const Contact& contact, int near,
                                       ZoneSet::Touch* touch) const {
  const Vector3d& normal = normal_[Index(near)];
  ZoneContact& made = touch->contact;
  made.tool = params_.tool;
  made.tool->radius /= unit_;
  made.tool->length /= unit_;
  made.placement = {contact.p_O / unit_, normal, contact.width / unit_};
  made.friction = params_.friction;
  const double depth = -contact.prescribed_O.dot(normal);
  touch->radius = std::max({2 * ToolRadius(contact.width, depth), kLeastRadius * edge(near),
                            params_.least_radius}) +
                  edge(near);
  AddToolPoints(edge(near), touch);
  return touch->nodes.empty() ? "no free surface at a contact point" : "";
}

std::string_view ZoneTouches::Make(const Contact& contact, const ContactPlace& at,
                                   ZoneSet::Touch* touch) const {
  const int near = NodeNear(contact.p_O);
  if (near < 0) return "no surface at a contact point";
  touch->centre_O = contact.p_O;
  touch->contact.loaded = contact.kind == Contact::Kind::kForce;
  const bool round = params_.tool.shape != Tool::Shape::kFlat;
  const bool bonded = std::isinf(params_.friction);
  if (!touch->contact.loaded && (round || (contact.width > 0 && !bonded))) {
    return MakeTool(contact, near, touch);
  }
  touch->radius = std::max({contact.width, kLeastRadius * edge(near), params_.least_radius}) +
                  kMargin * edge(near);
  if (touch->contact.loaded || at.is_point) {
    ZoneContact::Point point;
    for (const auto& [node, weight] : at.nodes) {
      point.emplace_back(static_cast<int>(touch->nodes.size()), weight);
      touch->nodes.push_back(node);
    }
    touch->contact.points.push_back(std::move(point));
  } else {
    for (const auto& [node, weight] : at.nodes) {
      touch->contact.points.push_back({{static_cast<int>(touch->nodes.size()), 1.0}});
      touch->nodes.push_back(node);
    }
  }
  const bool held =
      std::ranges::any_of(touch->nodes, [&](int node) { return IsAnyHeld(held_[Index(node)]); });
  return held && !touch->contact.loaded ? "a contact touches fixed nodes" : "";
}

std::optional<ZoneSet::Touch> ZoneTouches::Follow(const Contact& contact, const ToolContact& tool,
                                                  const ZoneSet::Touch& touch) const {
  const Vector3d& normal = touch.contact.placement.normal;
  const Vector3d moved = unit_ * (tool.apex() - touch.contact.placement.p);
  const double depth = -moved.dot(normal);
  // What lies under the tool, at rest.
  const Vector3d below = contact.p_O + moved + depth * normal - unit_ * tool.Dragged(normal);
  const int nearest = std::ranges::min(
      touch.nodes, {}, [&](int node) { return (mesh_.nodes[Index(node)] - below).squaredNorm(); });
  const Vector3d& centre = mesh_.nodes[Index(nearest)];
  const bool away = (centre - touch.centre_O).norm() > kFollows * edge(nearest);
  const double needed = std::max(
      {2 * ToolRadius(contact.width, depth), kLeastRadius * edge(nearest), params_.least_radius});
  if (!away && needed <= touch.radius) return std::nullopt;
  ZoneSet::Touch next = touch;
  next.nodes.clear();
  next.contact.points.clear();
  if (away) next.centre_O = centre;
  next.radius = needed + edge(nearest);
  AddToolPoints(edge(nearest), &next);
  if (next.nodes.empty()) return std::nullopt;
  return next;
}

ZoneTouches::Cover ZoneTouches::CoverOf(double width) const {
  std::vector<double> distance(mesh_.nodes.size(), std::numeric_limits<double>::infinity());
  Cover cover;
  cover.radius = params_.least_radius;
  for (std::size_t s = 0; s < mesh_.nodes.size(); ++s) {
    const auto& held = held_[s];
    if (!(edge_[s] > 0) || (held[0] && held[1] && held[2])) continue;
    cover.radius = std::max({cover.radius, width + edge_[s], (kLeastRadius + 1) * edge_[s]});
    for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) {
      distance[n] = std::min(distance[n], (mesh_.nodes[n] - mesh_.nodes[s]).squaredNorm());
    }
  }
  cover.extent = kZoneExtent * cover.radius;
  for (std::size_t n = 0; n < distance.size(); ++n) {
    if (distance[n] <= cover.extent * cover.extent) cover.nodes.push_back(static_cast<int>(n));
  }
  return cover;
}

}  // namespace palpate
