#include "slave/mechanics/fem/solid/contact_set.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>

#include "shared/geometry/index.h"
#include "shared/mesh/surface_patch.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// The nearest point of one triangle only.
std::optional<SurfacePlace> PlaceOn(const SurfaceMesh& surface, int triangle, const Vector3d& p) {
  const auto& corners = surface.triangles[Index(triangle)];
  SurfaceMesh one;
  for (const int node : corners) one.nodes.push_back(surface.nodes[Index(node)]);
  one.triangles.push_back({0, 1, 2});
  auto place = FindPlace(one, p);
  if (place) {
    place->triangle = triangle;
    if (place->node >= 0) place->node = corners[Index(place->node)];
  }
  return place;
}

}  // namespace

SolidContacts::SolidContacts(const ElementMesh& mesh, const std::vector<bool>& used,
                             double length_unit)
    : mesh_(mesh), used_(used), unit_(length_unit) {}

bool SolidContacts::Same(std::span<const Contact> contacts) const {
  return known_ && std::ranges::equal(contacts, contacts_, [](const Contact& a, const Contact& b) {
           return a.kind == b.kind && a.p_O == b.p_O && a.element == b.element &&
                  a.width == b.width;
         });
}

bool SolidContacts::Prepare(std::span<const Contact> contacts) {
  failure_ = {};
  changed_ = !Same(contacts);
  if (!changed_) return true;
  known_ = false;
  contacts_.assign(contacts.begin(), contacts.end());
  places_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!Find(contacts[i], &places_[i])) {
      if (failure_.empty()) failure_ = "no surface at a contact's place";
      return false;
    }
  }
  if (Overlap(contacts)) {
    failure_ = "a prescribed displacement overlaps with another contact";
    return false;
  }
  known_ = true;
  return true;
}

bool SolidContacts::Find(const Contact& contact, ContactPlace* place) {
  place->moved.clear();
  place->coarse = false;
  place->weights.clear();
  if (!contact.p_O.allFinite() || !std::isfinite(contact.width) || contact.width < 0 ||
      contact.element < -1 || contact.element >= static_cast<int>(mesh_.surface.triangles.size())) {
    failure_ = "a contact's place, width or triangle is none";
    return false;
  }
  const Vector3d p = contact.p_O / unit_;
  if (contact.width > 0) return FindPatch(contact, p, place);
  const auto vicinity = FindPlace(mesh_.touch_surface, p);
  if (vicinity && vicinity->node >= 0 && contact.element < 0) {
    if (!used_[Index(vicinity->node)]) {
      failure_ = "a contact's node belongs to no tetrahedron";
      return false;
    }
    place->moved.push_back(vicinity->node);
    place->weights.emplace_back(vicinity->node, 1);
    return true;
  }
  const auto found = contact.element >= 0 ? PlaceOn(mesh_.surface, contact.element, p)
                                          : FindPlace(mesh_.surface, p);
  if (!found) return false;
  if (found->node >= 0) {
    place->moved.push_back(found->node);
    place->weights.emplace_back(found->node, 1);
  } else {
    PointWeights(found->triangle, found->weights, place);
  }
  return true;
}

// The element's own shape functions there.
void SolidContacts::PointWeights(int triangle, const Vector3d& weights, ContactPlace* place) const {
  const auto& face = mesh_.faces[Index(triangle)];
  const auto add = [&](std::size_t i, double weight) {
    if (weight != 0) place->weights.emplace_back(face[i], weight);
  };
  const bool quadratic = mesh_.nodes_per_element == 10;
  for (int i = 0; i < 3; ++i) {
    add(Index(i), quadratic ? weights[i] * (2 * weights[i] - 1) : weights[i]);
  }
  for (int i = 0; quadratic && i < 3; ++i) {
    add(Index(3 + i), 4 * weights[i] * weights[(i + 1) % 3]);
  }
}

bool SolidContacts::FindPatch(const Contact& contact, const Vector3d& p, ContactPlace* place) {
  const double width = contact.width / unit_;
  const auto found = contact.element >= 0 ? PlaceOn(mesh_.surface, contact.element, p)
                                          : FindPlace(mesh_.surface, p);
  if (!found) return false;
  const SurfacePatch patch = PatchAt(mesh_.surface, *found, p, width);
  std::map<int, double> load;
  double area = 0;
  for (const int triangle : patch.triangles) {
    const double A = Area(mesh_.surface, triangle);
    const auto& face = mesh_.faces[Index(triangle)];
    const std::size_t first = mesh_.nodes_per_element == 10 ? 3 : 0;
    for (std::size_t i = 0; i < 3; ++i) load[face[first + i]] += A / 3;
    area += A;
  }
  if (!(area > 0)) return false;
  for (const auto& [node, share] : load) place->weights.emplace_back(node, share / area);
  const bool is_quadratic = mesh_.nodes_per_element == 10;
  if (contact.kind == Contact::Kind::kForce) {
    place->coarse = IsPatchCoarse(CoverOf(
        patch, is_quadratic ? PatchBasis::kLoadedTriangles10 : PatchBasis::kLoadedTriangles));
    return true;
  }

  SurfacePatch moved = patch;
  if (is_quadratic) {
    auto vicinity = FindPlace(mesh_.touch_surface, p);
    if (!vicinity) vicinity = found;  // farther than half a quarter triangle's edge
    if (vicinity->triangle >= 0) {
      moved = PatchAt(mesh_.touch_surface, *vicinity, p, width);
    }
  }
  place->coarse = IsPatchCoarse(
      CoverOf(moved, is_quadratic ? PatchBasis::kMovedNodes10 : PatchBasis::kMovedNodes));
  if (moved.nodes.empty()) {
    place->weights.clear();
    if (found->node >= 0) {
      place->moved.push_back(found->node);
      place->weights.emplace_back(found->node, 1);
    } else {
      PointWeights(found->triangle, found->weights, place);
    }
    return true;
  }
  place->moved = std::move(moved.nodes);
  return true;
}

// No node is moved twice, and what else acts on moved nodes (the rim of a neighbouring patch) rests
// for less than half on them.
bool SolidContacts::Overlap(std::span<const Contact> contacts) {
  owner_.assign(Index(mesh_.node_count()), -1);
  const auto moves_nodes = [&](std::size_t i) {
    return contacts[i].kind == Contact::Kind::kDisplacement && !places_[i].moved.empty();
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!moves_nodes(i)) continue;
    for (const int node : places_[i].moved) {
      if (owner_[Index(node)] >= 0) return true;
      owner_[Index(node)] = static_cast<int>(i);
    }
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (moves_nodes(i)) continue;
    double shared = 0;
    for (const auto& [node, weight] : places_[i].weights) {
      if (owner_[Index(node)] >= 0) shared += std::abs(weight);
    }
    if (shared >= 0.5) return true;
  }
  return false;
}

}  // namespace palpate
