#include "slave/mechanics/footprint/contact_footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "slave/mechanics/footprint/rim_share.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Tolerances as in disc_patch.cpp.
constexpr double kOnNode = 1e-6;   // of the diagonal
constexpr double kSlack = 1e-9;    // relative, of the patch's radius
constexpr double kSameSide = 0.5;  // cosine of the angle between normals
constexpr double kOnEdge = 1e-9;   // barycentric weight
constexpr double kWider = 1.15;    // ratio of successive trial discs
constexpr double kPlane = 0.01;    // of a disc's area and rim
constexpr double kEvenGap = 1e-3;  // largest gap under a wider face, of its width
constexpr double kDeeper = 1.25;   // than the depth: more places than a round tool touches
// Nodes under a rigid tool below which its force is flagged. [measured: rim_share.h; a sphere's
// force changes by a tenth with one node more or less]
constexpr std::size_t kFewestUnderTool = 6, kFewestUnderTool10 = 19, kFewestUnderSphere = 8;

// Ten-node tetrahedra act as a narrower face, by this part of a mid-edge node's part radius.
// [measured: bonded and sliding discs on boxes, 2 to 5 elements across, 1 to 6 % too soft]
constexpr double kWiderByPart = 0.15;

constexpr std::string_view kNoNormal = "the surface has no normal there";

// Number of nodes under a flat face, those at its rim by their shares.
double NodesUnder(const ContactFootprint& footprint) {
  return std::accumulate(footprint.holds.begin(), footprint.holds.end(), 0.0,
                         [](double sum, const ToolHold& hold) { return sum + hold.share; });
}

constexpr std::string_view kNoPlace =
    "no surface is there: the distance is more than half the longest edge of the nearest triangle";

}  // namespace

SurfaceFootprints::SurfaceFootprints(SurfaceMesh surface, std::vector<char> held, bool quarters)
    : surface_(std::move(surface)),
      diagonal_(Diagonal(surface_.nodes)),
      around_(surface_),
      held_(std::move(held)),
      quarters_(quarters) {
  const int triangles = static_cast<int>(surface_.triangles.size());
  for (int t = 0; t < triangles; ++t) {
    normals_.push_back(Normal(surface_, t));
    centroids_.push_back(Centroid(surface_, t));
    areas_.push_back(Area(surface_, t));
  }
  is_corner_.assign(surface_.nodes.size(), quarters_ ? 1 : 0);
  for (int t = 3; t < triangles && quarters_; t += 4) {  // the middle one of four
    for (const int node : surface_.triangles[Index(t)]) is_corner_[Index(node)] = 0;
  }
  seen_.assign(surface_.nodes.size(), 0);
  load_.assign(surface_.nodes.size(), 0);
  reached_.assign(surface_.triangles.size(), 0);
  searched_.reserve(surface_.triangles.size());
  patch_.nodes.reserve(surface_.nodes.size());
  patch_.triangles.reserve(surface_.triangles.size());
}

std::optional<SurfacePlace> SurfaceFootprints::Find(const Contact& contact) const {
  if (contact.element < 0) return FindPlace(surface_, contact.p_O);
  if (contact.element >= static_cast<int>(surface_.triangles.size())) return std::nullopt;
  return OnTriangle(contact.element, contact.p_O);
}

std::optional<SurfacePlace> SurfaceFootprints::OnTriangle(int triangle, const Vector3d& p_O) const {
  const auto& corners = surface_.triangles[Index(triangle)];
  const double near = kOnNode * diagonal_;
  SurfacePlace place;
  place.triangle = triangle;
  for (int v = 0; v < 3; ++v) {
    const int node = corners[Index(v)];
    const double distance2 = (surface_.nodes[Index(node)] - p_O).squaredNorm();
    if (distance2 > near * near) continue;
    place.node = node;
    place.weights = Vector3d::Unit(v);
    place.distance = std::sqrt(distance2);
    return place;
  }
  const Vector3d &a = surface_.nodes[Index(corners[0])], &b = surface_.nodes[Index(corners[1])],
                 &c = surface_.nodes[Index(corners[2])];
  const Vector3d area = (b - a).cross(c - a);
  const Vector3d from_a = p_O - a;
  const double height = from_a.dot(area) / area.norm();
  place.weights[1] = from_a.cross(c - a).dot(area) / area.squaredNorm();
  place.weights[2] = (b - a).cross(from_a).dot(area) / area.squaredNorm();
  place.weights[0] = 1 - place.weights[1] - place.weights[2];
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  if (place.weights.minCoeff() >= 0 && std::abs(height) <= 0.5 * longest) {
    place.distance = std::abs(height);
    return place;
  }
  const auto found = FindPlace({{a, b, c}, {{0, 1, 2}}}, p_O);  // beside the triangle
  if (!found) return std::nullopt;
  place.weights = found->weights;
  place.distance = found->distance;
  return place;
}

Vector3d SurfaceFootprints::NormalAt(const SurfacePlace& place) const {
  const auto& corners = surface_.triangles[Index(place.triangle)];
  std::array<int, 3> touched{place.node, -1, -1};
  std::size_t count = 1;
  if (place.node < 0) {
    count = 0;
    for (int v = 0; v < 3; ++v) {
      if (place.weights[v] > kOnEdge) touched[count++] = corners[Index(v)];
    }
  }
  Vector3d sum = Vector3d::Zero();
  for (const int t : TrianglesOf(touched[0])) {
    const auto& nodes = surface_.triangles[Index(t)];
    const bool all = std::all_of(touched.begin(), touched.begin() + static_cast<long>(count),
                                 [&](int node) { return std::ranges::count(nodes, node) > 0; });
    if (all) sum += normals_[Index(t)];
  }
  const double length = sum.norm();
  return length > kOnEdge ? Vector3d(sum / length) : Vector3d::Zero();
}

void SurfaceFootprints::FindPatch(const SurfacePlace& place, const Vector3d& p_O, double width) {
  const Vector3d facing = NormalAt(place);
  const double radius = 0.5 * width * (1 + kSlack);
  ++patches_;
  patch_.nodes.clear();
  patch_.triangles.clear();
  patch_.disc = {};
  patch_.node_area = patch_.triangle_area = 0;
  searched_.clear();
  const auto reach = [&](int t) {
    if (std::exchange(reached_[Index(t)], patches_) == patches_) return;
    if (normals_[Index(t)].dot(facing) >= kSameSide) searched_.push_back(t);
  };
  const auto reach_around = [&](int t) {
    for (const int node : surface_.triangles[Index(t)]) {
      for (const int around : TrianglesOf(node)) reach(around);
    }
  };
  reach_around(place.triangle);
  for (std::size_t next = 0; next < searched_.size(); ++next) {
    const int t = searched_[next];
    if (AddShare(t, p_O, radius)) reach_around(t);
  }
  std::ranges::sort(patch_.nodes);
  std::ranges::sort(patch_.triangles);
  if (patch_.triangles.empty()) AddTriangle(place.triangle);
}

bool SurfaceFootprints::AddShare(int triangle, const Vector3d& p_O, double radius) {
  const DiscShare disc = DiscOnTriangle(surface_, triangle, p_O, radius);
  patch_.disc.area += disc.area;
  patch_.disc.rim += disc.rim;
  patch_.disc.first += disc.first;
  if ((centroids_[Index(triangle)] - p_O).norm() <= radius) AddTriangle(triangle);
  bool is_within = disc.area > 0;
  for (const int node : surface_.triangles[Index(triangle)]) {
    if ((surface_.nodes[Index(node)] - p_O).norm() > radius) continue;
    is_within = true;
    patch_.node_area += areas_[Index(triangle)] / 3;
    if (std::exchange(seen_[Index(node)], patches_) != patches_) patch_.nodes.push_back(node);
  }
  return is_within;
}

void SurfaceFootprints::AddTriangle(int triangle) {
  patch_.triangles.push_back(triangle);
  patch_.triangle_area += areas_[Index(triangle)];
}

void SurfaceFootprints::FindDisc(const Contact& contact, PatchBasis basis,
                                 ContactFootprint* footprint) {
  footprint->patch_error = footprint->reach = footprint->narrower = 0;
  if (contact.width == 0) return;
  FindPatch(footprint->at, contact.p_O, contact.width);
  const PatchCover cover = CoverOf(patch_, basis);
  footprint->patch_error = PatchError(cover);
  if (held_.empty() || !may_widen_) return;
  if (footprint->patch_error == 0) return;
  if (!FindWiderDisc(contact, basis, footprint)) {
    FindPatch(footprint->at, contact.p_O, contact.width);
  }
}

// Searches from the first width that may contain three pieces.
bool SurfaceFootprints::FindWiderDisc(const Contact& contact, PatchBasis basis,
                                      ContactFootprint* footprint) {
  const auto& corners = surface_.triangles[Index(footprint->at.triangle)];
  Vector3d p_O = Vector3d::Zero();
  double edge = 0;
  for (int v = 0; v < 3; ++v) {
    const Vector3d& corner = surface_.nodes[Index(corners[Index(v)])];
    p_O += footprint->at.weights[v] * corner;
    edge = std::max(edge, (surface_.nodes[Index(corners[Index((v + 1) % 3)])] - corner).norm());
  }
  const double thickness = ThicknessAt(footprint->at, p_O);
  for (double width = std::max(kWider * contact.width, edge); width <= thickness; width *= kWider) {
    FindPatch(footprint->at, p_O, width);
    if (!IsWholeAndPlane(width)) return false;
    const PatchCover cover = CoverOf(patch_, basis);
    // On quadratic faces few nodes are no disc, however large their area is.
    if (quarters_ ? PatchError(cover) > 0 : IsPatchCoarse(cover)) continue;
    if (HoldsPatch()) return false;
    footprint->patch_error = 0;
    footprint->reach = width / 2;
    footprint->narrower = 2 / contact.width - 2 / (PatchStiffness(cover) * width);
    return true;
  }
  return false;
}

bool SurfaceFootprints::IsWholeAndPlane(double width) const {
  const double area = std::numbers::pi / 4 * width * width;
  return std::abs(patch_.disc.area / area - 1) < kPlane &&
         patch_.disc.rim > (1 - kPlane) * 2 * std::numbers::pi;
}

bool SurfaceFootprints::HoldsPatch() const {
  const auto is_held = [this](int place) { return held_[Index(place)] != 0; };
  return std::ranges::any_of(patch_.triangles, [&](int t) {
    return std::ranges::any_of(surface_.triangles[Index(t)], is_held);
  });
}

double SurfaceFootprints::ThicknessAt(const SurfacePlace& place, const Vector3d& p_O) const {
  const Vector3d inward = -normals_[Index(place.triangle)];
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < normals_.size(); ++t) {
    const double slope = normals_[t].dot(inward);
    if (slope <= 0) continue;  // the triangle faces the position
    const auto& corners = surface_.triangles[t];
    const Vector3d& a = surface_.nodes[Index(corners[0])];
    const double distance = (a - p_O).dot(normals_[t]) / slope;
    if (distance <= 0 || distance >= nearest) continue;
    const Vector3d hit = p_O + distance * inward;
    const auto is_inside = [&](int i, int j) {
      const Vector3d &p = surface_.nodes[Index(corners[Index(i)])],
                     &q = surface_.nodes[Index(corners[Index(j)])];
      return (q - p).cross(hit - p).dot(normals_[t]) >= -kSlack * areas_[t];
    };
    if (is_inside(0, 1) && is_inside(1, 2) && is_inside(2, 0)) nearest = distance;
  }
  return nearest;
}

// A third of the area of each triangle of the patch to each of its nodes.
void SurfaceFootprints::ShareAmongNodes(ContactFootprint* footprint) {
  for (const int t : patch_.triangles) {
    const double area = areas_[Index(t)];
    for (const int node : surface_.triangles[Index(t)]) {
      if (load_[Index(node)] == 0) footprint->places.push_back({node, 0});
      load_[Index(node)] += area / 3;
    }
  }
  std::ranges::sort(footprint->places, {}, &PlaceWeight::place);
  for (auto& [node, weight] : footprint->places) {
    weight = load_[Index(node)] / patch_.triangle_area;
    load_[Index(node)] = 0;
  }
}

template <class PositionOf>
void SurfaceFootprints::SetArms(const Contact& contact, const PositionOf& at,
                                ContactFootprint* footprint) const {
  footprint->arms.clear();
  if (footprint->reach != 0) return;
  for (const PlaceWeight& touched : footprint->places) {
    footprint->arms.push_back(at(touched.place) - contact.p_O);
  }
  const auto weight = [&](std::size_t i) { return footprint->places[i].weight; };
  CentreArms(patch_.disc, weight, &footprint->arms);
}

Vector3d SurfaceFootprints::AxisAt(const SurfacePlace& place) const {
  const Vector3d& facing = normals_[Index(place.triangle)];
  const auto& corners = surface_.triangles[Index(place.triangle)];
  Vector3d sum = Vector3d::Zero();
  for (int v = 0; v < 3; ++v) {
    Vector3d at_corner = Vector3d::Zero();
    for (const int t : TrianglesOf(corners[Index(v)])) {
      if (normals_[Index(t)].dot(facing) >= kSameSide)
        at_corner += areas_[Index(t)] * normals_[Index(t)];
    }
    sum += place.weights[v] * at_corner.stableNormalized();
  }
  return sum.stableNormalized();
}

// A third of each triangle, the part that is nearer to the node than to the others by its
// barycentric weights: its centroid has the weights 22, 7, 7 / 36.
SurfaceFootprints::Part SurfaceFootprints::PartOf(int node, const Vector3d& axis) const {
  constexpr double kOfOthers = 7.0 / 36;
  const double share =
      quarters_ ? 4.0 / 9 : 1.0 / 3;  // mid-edge nodes have the corners' parts, too
  double area = 0;
  Part part;
  for (const int t : TrianglesOf(node)) {
    const double facing = normals_[Index(t)].dot(axis);
    if (facing < kSameSide) continue;
    const double third = share * facing * areas_[Index(t)];
    area += third;
    for (const int corner : surface_.triangles[Index(t)]) {
      part.centre +=
          third * kOfOthers * (surface_.nodes[Index(corner)] - surface_.nodes[Index(node)]);
    }
  }
  if (area > 0) part.centre /= area;
  part.radius = PartRadius(area);
  return part;
}

void SurfaceFootprints::HoldUnder(const Contact& contact, double width,
                                  ContactFootprint* footprint) {
  const Vector3d& axis = footprint->normal_O;
  footprint->places.clear();
  footprint->holds.clear();
  ++patches_;
  for (const int t : searched_) {
    for (const int node : surface_.triangles[Index(t)]) {
      if (std::exchange(seen_[Index(node)], patches_) == patches_) continue;
      if (is_corner_[Index(node)] != 0) continue;
      const Vector3d from = surface_.nodes[Index(node)] - contact.p_O;
      const double height = axis.dot(from);
      const Part part = PartOf(node, axis);
      if (part.radius == 0) continue;
      const Vector3d centre = from + part.centre;
      const double share = ShareUnderDisc(width / 2 + (quarters_ ? kWiderByPart * part.radius : 0),
                                          part.radius, (centre - axis.dot(centre) * axis).norm());
      if (share < kLeastShare) continue;
      footprint->places.push_back({node, share});
      footprint->holds.push_back({std::max(0.0, -height), share, part.radius});
    }
  }
}

void SurfaceFootprints::HoldWhole(const Contact& contact, ContactFootprint* footprint) {
  footprint->places.clear();
  footprint->holds.clear();
  for (const int node : patch_.nodes) {
    if (is_corner_[Index(node)] != 0) continue;
    const double height = footprint->normal_O.dot(surface_.nodes[Index(node)] - contact.p_O);
    footprint->places.push_back({node, 1});
    footprint->holds.push_back({std::max(0.0, -height), 1, 0});
  }
}

// The surface is searched from the place outwards, as far as the tool reaches it.
void SurfaceFootprints::HoldUnderSphere(const Contact& contact, ContactFootprint* footprint) {
  const Vector3d& axis = footprint->normal_O;
  const double R = contact.radius, depth = -axis.dot(contact.prescribed_O);
  footprint->depth = kDeeper * std::max(depth, 0.0);
  ++patches_;
  searched_.clear();
  const auto reach_around = [&](int node) {
    for (const int t : TrianglesOf(node)) {
      if (std::exchange(reached_[Index(t)], patches_) == patches_) continue;
      if (normals_[Index(t)].dot(axis) > 0) searched_.push_back(t);
    }
  };
  for (const int node : surface_.triangles[Index(footprint->at.triangle)]) reach_around(node);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t next = 0; next < searched_.size(); ++next) {
    for (const int node : surface_.triangles[Index(searched_[next])]) {
      if (std::exchange(seen_[Index(node)], patches_) == patches_) continue;
      const Vector3d from = surface_.nodes[Index(node)] - contact.p_O;
      const double height = axis.dot(from), rho2 = (from - height * axis).squaredNorm();
      if (!(rho2 < R * R)) continue;
      const bool is_corner = is_corner_[Index(node)] != 0;
      const double gap = std::max(0.0, rho2 / (R + std::sqrt(R * R - rho2)) - height);
      if (is_corner && gap <= footprint->depth) reach_around(node);
      if (is_corner) continue;
      const bool is_nearest = gap < nearest;
      if (gap > footprint->depth && !is_nearest) continue;
      if (is_nearest && nearest > footprint->depth) {  // the former one is not within reach
        footprint->places.clear();
        footprint->holds.clear();
      }
      nearest = std::min(nearest, gap);
      footprint->places.push_back({node, 1});
      footprint->holds.push_back({gap, 1, 0});
      if (gap <= footprint->depth) reach_around(node);
    }
  }
}

// Like FindWiderDisc, for a tool.
bool SurfaceFootprints::WidenTool(const Contact& contact, ContactFootprint* footprint) {
  Contact wider = contact;
  wider.p_O.setZero();
  double edge = 0;
  const auto& corners = surface_.triangles[Index(footprint->at.triangle)];
  for (int v = 0; v < 3; ++v) {
    const Vector3d& corner = surface_.nodes[Index(corners[Index(v)])];
    wider.p_O += footprint->at.weights[v] * corner;
    edge = std::max(edge, (surface_.nodes[Index(corners[Index((v + 1) % 3)])] - corner).norm());
  }
  const double thickness = ThicknessAt(footprint->at, wider.p_O);
  for (double width = std::max(kWider * contact.width, edge); width <= thickness; width *= kWider) {
    FindPatch(footprint->at, wider.p_O, width);
    if (!IsWholeAndPlane(width) || HoldsPatch()) return false;
    HoldUnder(wider, width, footprint);
    // A wider face touches a curved surface at another depth.
    const auto is_apart = [&](const ToolHold& hold) { return hold.gap > kEvenGap * width; };
    if (std::ranges::any_of(footprint->holds, is_apart)) return false;
    if (NodesUnder(*footprint) < static_cast<double>(footprint->fewest)) continue;
    footprint->reach = width / 2;
    footprint->narrower = 2 / contact.width - 2 / width;
    return true;
  }
  return false;
}

std::string_view SurfaceFootprints::OnTool(const Contact& contact, bool whole,
                                           ContactFootprint* footprint) {
  const auto at = Find(contact);
  if (!at) return kNoPlace;
  footprint->at = *at;
  footprint->places.clear();
  footprint->holds.clear();
  footprint->arms.clear();
  footprint->point = false;
  footprint->patch_error = footprint->reach = footprint->narrower = 0;
  footprint->normal_O = AxisAt(*at);
  footprint->fewest = quarters_ ? kFewestUnderTool10 : kFewestUnderTool;
  if (footprint->normal_O.isZero(0)) return kNoNormal;
  if (contact.radius > 0) {
    footprint->fewest = kFewestUnderSphere;
    HoldUnderSphere(contact, footprint);
  } else {
    FindPatch(*at, contact.p_O, contact.width);
    if (whole) {
      HoldWhole(contact, footprint);
      if (footprint->places.empty()) return OnNodes(contact, footprint);
    } else {
      HoldUnder(contact, contact.width, footprint);
    }
    const bool is_coarse = NodesUnder(*footprint) < static_cast<double>(footprint->fewest);
    const bool may_widen = is_coarse && !held_.empty() && may_widen_;
    if (may_widen && !WidenTool(contact, footprint)) {
      FindPatch(*at, contact.p_O, contact.width);
      HoldUnder(contact, contact.width, footprint);
    }
    if (is_coarse && footprint->reach == 0) {
      const double nodes = NodesUnder(*footprint);
      // Springs alone are much too soft.
      footprint->patch_error = nodes < 1 ? std::numeric_limits<double>::infinity()
                                         : FewTouchedError(nodes, footprint->fewest, false);
    }
    if (footprint->places.empty()) {  // between the nodes' parts
      int nearest = 0;
      at->weights.maxCoeff(&nearest);
      const auto& nodes = surface_.triangles[Index(at->triangle)];
      while (is_corner_[Index(nodes[Index(nearest)])] != 0) nearest = (nearest + 1) % 3;
      footprint->places.push_back({nodes[Index(nearest)], 1});
      footprint->holds.push_back({0, 1, 0});
    }
  }
  double sum = 0;
  for (const PlaceWeight& touched : footprint->places) sum += touched.weight;
  for (PlaceWeight& touched : footprint->places) touched.weight /= sum;
  if (contact.radius > 0) {
    for (const PlaceWeight& touched : footprint->places) {
      footprint->arms.push_back(surface_.nodes[Index(touched.place)] - contact.p_O);
    }
  } else {
    SetArms(
        contact, [this](int node) -> const Vector3d& { return surface_.nodes[Index(node)]; },
        footprint);
  }
  return {};
}

std::string_view SurfaceFootprints::OnNodes(const Contact& contact, ContactFootprint* footprint) {
  const auto at = Find(contact);
  if (!at) return kNoPlace;
  footprint->at = *at;
  footprint->places.clear();
  footprint->arms.clear();
  footprint->holds.clear();
  footprint->point = true;
  footprint->normal_O = NormalAt(*at);
  const auto node_at = [this](int node) -> const Vector3d& { return surface_.nodes[Index(node)]; };
  const bool loads = contact.kind == Contact::Kind::kForce;
  FindDisc(contact,
           loads       ? PatchBasis::kLoadedTriangles
           : quarters_ ? PatchBasis::kMovedNodes10
                       : PatchBasis::kMovedNodes,
           footprint);
  if (contact.width > 0 && loads) {
    ShareAmongNodes(footprint);
    SetArms(contact, node_at, footprint);
  } else if (contact.width > 0 && !patch_.nodes.empty()) {
    const std::size_t count = patch_.nodes.size();
    footprint->point = count == 1;
    for (const int node : patch_.nodes) {
      footprint->places.push_back({node, 1 / static_cast<double>(count)});
    }
    SetArms(contact, node_at, footprint);
  } else if (at->node >= 0) {
    footprint->places.push_back({at->node, 1});
  } else {
    for (int v = 0; v < 3; ++v) {
      footprint->places.push_back(
          {surface_.triangles[Index(at->triangle)][Index(v)], at->weights[v]});
    }
  }
  return {};
}

std::string_view SurfaceFootprints::OnTriangles(const Contact& contact, ContactFootprint* footprint,
                                                PatchBasis basis) {
  footprint->places.clear();
  footprint->arms.clear();
  footprint->holds.clear();
  footprint->point = true;
  footprint->patch_error = footprint->reach = footprint->narrower = 0;
  const int triangles = static_cast<int>(surface_.triangles.size());
  if (contact.width == 0 && contact.element >= 0 && contact.element < triangles) {
    footprint->places.push_back({contact.element, 1});
    footprint->normal_O = Normal(surface_, contact.element);
    return {};
  }
  const auto at = Find(contact);
  if (!at) return kNoPlace;
  footprint->at = *at;
  footprint->normal_O = NormalAt(*at);
  if (contact.width == 0) {
    footprint->places.push_back({at->triangle, 1});
    return {};
  }
  FindDisc(contact, basis, footprint);
  for (const int t : patch_.triangles) {
    footprint->places.push_back({t, areas_[Index(t)] / patch_.triangle_area});
  }
  footprint->point = footprint->places.size() == 1;
  SetArms(
      contact, [this](int t) -> const Vector3d& { return centroids_[Index(t)]; }, footprint);
  return {};
}

}  // namespace palpate
