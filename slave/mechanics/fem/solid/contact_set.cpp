#include "slave/mechanics/fem/solid/contact_set.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "shared/geometry/index.h"
#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {
SolidContacts::SolidContacts(const ElementMesh& mesh, const std::vector<bool>& used,
                             double length_unit)
    : mesh_(mesh), used_(used), unit_(length_unit), footprints_(mesh.surface) {}

bool SolidContacts::Prepare(std::span<const Contact> contacts) {
  failure_ = {};
  changed_ = !known_ || !std::ranges::equal(contacts, contacts_,
                                            [](const auto& a, const auto& b) { return a.IsAt(b); });
  if (!changed_) return true;
  known_ = false;
  contacts_.assign(contacts.begin(), contacts.end());
  places_.resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (Find(contacts[i], &places_[i])) continue;
    return failure_.empty() ? Refuse("no surface at a contact point") : false;
  }
  if (Overlap(contacts)) return Refuse("a prescribed displacement overlaps with another contact");
  known_ = true;
  return true;
}

bool SolidContacts::Find(const Contact& contact, ContactPlace* place) {
  place->moved.clear();
  place->arms.clear();
  place->coarse = false;
  place->weights.clear();
  if (!contact.p_O.allFinite() || !std::isfinite(contact.width) || contact.width < 0 ||
      contact.element < -1 || contact.element >= static_cast<int>(mesh_.surface.triangles.size())) {
    return Refuse("a contact's position, width or triangle is invalid");
  }
  Contact here = contact;
  here.p_O /= unit_;
  here.width /= unit_;
  if (contact.width > 0) return FindPatch(here, place);
  if (contact.element < 0) {
    const auto vicinity = FindPlace(mesh_.touch_surface, here.p_O);
    if (vicinity && vicinity->node >= 0) {
      if (!used_[Index(vicinity->node)])
        return Refuse("a contact's node belongs to no tetrahedron");
      place->moved.push_back(vicinity->node);
      place->weights.emplace_back(vicinity->node, 1);
      return true;
    }
  }
  if (!footprints_.OnNodes(here, &footprint_).empty()) return false;
  Touch(footprint_.at, place);
  return true;
}

void SolidContacts::Touch(const SurfacePlace& at, ContactPlace* place) const {
  if (at.node >= 0) {
    place->moved.push_back(at.node);
    place->weights.emplace_back(at.node, 1);
  } else {
    PointWeights(at.triangle, at.weights, place);
  }
}

// The element's own shape functions there.
void SolidContacts::PointWeights(int triangle, const Eigen::Vector3d& weights,
                                 ContactPlace* place) const {
  const auto& face = mesh_.faces[Index(triangle)];
  const auto add = [&](std::size_t i, double weight) {
    if (weight != 0) place->weights.emplace_back(face[i], weight);
  };
  const bool quadratic = mesh_.nodes_per_element == 10;
  for (int i = 0; i < 3; ++i) {
    add(Index(i), quadratic ? weights[i] * (2 * weights[i] - 1) : weights[i]);
  }
  for (int i = 0; quadratic && i < 3; ++i) add(Index(3 + i), 4 * weights[i] * weights[(i + 1) % 3]);
}

bool SolidContacts::FindPatch(const Contact& here, ContactPlace* place) {
  const bool quadratic = mesh_.nodes_per_element == 10;
  const auto basis = quadratic ? PatchBasis::kLoadedTriangles10 : PatchBasis::kLoadedTriangles;
  if (!footprints_.OnTriangles(here, &footprint_, basis).empty()) return false;
  if (here.kind == Contact::Kind::kForce) {
    std::map<int, double> load;
    for (const auto& [triangle, share] : footprint_.places) {
      const auto& face = mesh_.faces[Index(triangle)];
      for (std::size_t i = 0; i < 3; ++i) load[face[quadratic ? 3 + i : i]] += share / 3;
    }
    place->weights.assign(load.begin(), load.end());
    place->coarse = footprint_.coarse;
    SetArms(here, footprints_.patch().disc, place);
    return true;
  }
  const SurfacePlace at = footprint_.at;
  const auto vicinity = quadratic ? FindPlace(mesh_.touch_surface, here.p_O) : std::nullopt;
  // `at`: farther than half a quarter triangle's edge.
  DiscPatch patch = PatchAt(mesh_.touch_surface, vicinity.value_or(at), here.p_O, here.width);
  place->coarse = IsPatchCoarse(
      CoverOf(patch, quadratic ? PatchBasis::kMovedNodes10 : PatchBasis::kMovedNodes));
  place->moved = std::move(patch.nodes);
  if (place->moved.empty()) {
    Touch(at, place);
  } else {
    SetArms(here, patch.disc, place);
  }
  return true;
}

void SolidContacts::SetArms(const Contact& here, const DiscShare& disc, ContactPlace* place) const {
  for (const int node : place->moved) place->arms.push_back(mesh_.nodes[Index(node)] - here.p_O);
  for (const auto& [node, share] : place->weights) {
    place->arms.push_back(mesh_.nodes[Index(node)] - here.p_O);
  }
  const bool moves = !place->moved.empty();
  CentreArms(
      disc, [&](std::size_t i) { return moves ? 1.0 : place->weights[i].second; }, &place->arms);
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
