#include "slave/mechanics/fem/contact_set.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "shared/geometry/index.h"
#include "shared/mesh/surface_patch.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate::fem {
namespace {

bool Finite(const Contact& contact) {
  return contact.p_O.allFinite() && contact.prescribed_O.allFinite() &&
         std::isfinite(contact.width) && contact.width >= 0;
}

}  // namespace

ContactSet::ContactSet(const SolidMesh& mesh, const FemBody& body)
    : body_(body), surface_(SurfaceOf(mesh)) {}

ContactSet::Result ContactSet::Update(std::span<const Contact> contacts, Constraints& constraints) {
  bool holds_same = ready_ && keys_.size() == contacts.size(), same = holds_same;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Contact& contact = contacts[k];
    if (!Finite(contact)) return {Change::kHolds, "a number is not finite", static_cast<int>(k)};
    if (!holds_same) continue;
    if (keys_[k] == Key{contact.kind, contact.p_O, contact.width}) continue;
    same = false;
    const auto moves = Contact::Kind::kDisplacement;
    if (contact.kind == moves || keys_[k].kind == moves) holds_same = false;
  }
  if (same) return {};
  const std::size_t known = ready_ ? keys_.size() : 0;
  Forget();
  places_.resize(contacts.size());
  keys_.resize(contacts.size());
  if (!holds_same) constraints.Clear();
  int holds = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    Place& place = places_[k];
    const Key key{contacts[k].kind, contacts[k].p_O, contacts[k].width};
    if (k >= known || !(keys_[k] == key)) {
      keys_[k] = key;
      if (const char* refusal = Find(contacts[k], place)) {
        return {Change::kHolds, refusal, static_cast<int>(k)};
      }
    }
    place.hold = -1;
    if (contacts[k].kind != Contact::Kind::kDisplacement) continue;
    place.hold = holds++;
    if (!holds_same && !Hold(place, constraints)) {
      return {Change::kHolds, "it overlaps another contact", static_cast<int>(k)};
    }
  }
  ready_ = true;
  return {holds_same ? Change::kLoads : Change::kHolds, nullptr, -1};
}

const char* ContactSet::Find(const Contact& contact, Place& place) {
  const auto found = FindPlace(surface_, contact.p_O);
  if (!found) return "no node or surface is there";
  place.nodes.clear();
  place.weights.clear();
  place.point = false;
  place.coarse = false;
  const auto add = [&](int mesh_node, double weight) {
    place.nodes.push_back(body_.Number(mesh_node));
    place.weights.push_back(weight);
  };
  const bool holds = contact.kind == Contact::Kind::kDisplacement;
  SurfacePatch patch;
  if (contact.width > 0 && found->triangle >= 0) {
    patch = PatchAt(surface_, *found, contact.p_O, contact.width);
    place.coarse = IsPatchCoarse(
        CoverOf(patch, holds ? PatchBasis::kMovedNodes : PatchBasis::kLoadedTriangles));
  }
  if (!patch.triangles.empty() && !holds) {
    AddLoad(patch.triangles, place);
  } else if (!patch.nodes.empty() && holds) {
    for (const int node : patch.nodes) add(node, 1.0 / static_cast<double>(patch.nodes.size()));
  } else if (found->node >= 0) {
    add(found->node, 1);
  } else {
    place.point = true;
    const auto& triangle = surface_.triangles[Index(found->triangle)];
    for (int a = 0; a < 3; ++a) {
      if (found->weights[a] > 0 || holds) add(triangle[Index(a)], found->weights[a]);
    }
  }
  for (const int node : place.nodes) {
    if (body_.Dangling(node)) return "its node belongs to no element";
  }
  return nullptr;
}

// A third of each triangle's share of the area per node.
void ContactSet::AddLoad(const std::vector<int>& triangles, Place& place) const {
  double area = 0;
  std::map<int, double> share;
  for (const int t : triangles) {
    const double a = Area(surface_, t);
    area += a;
    for (const int node : surface_.triangles[Index(t)]) share[node] += a / 3;
  }
  for (const auto& [node, a] : share) {
    place.nodes.push_back(body_.Number(node));
    place.weights.push_back(a / area);
  }
}

bool ContactSet::Hold(const Place& place, Constraints& constraints) const {
  if (place.point) {
    return constraints.HoldPoint({place.nodes[0], place.nodes[1], place.nodes[2]},
                                 {place.weights[0], place.weights[1], place.weights[2]});
  }
  return constraints.HoldNodes(place.nodes);
}

bool ContactSet::Apply(std::span<const Contact> contacts, double length_unit, double force_unit,
                       Constraints& constraints, NodeVector& f) const noexcept {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Place& place = places_[k];
    if (place.hold >= 0) {
      if (!constraints.Move(place.hold, contacts[k].prescribed_O / length_unit)) return false;
      continue;
    }
    const Eigen::Vector3d force = contacts[k].prescribed_O / force_unit;
    for (std::size_t n = 0; n < place.nodes.size(); ++n) {
      for (int c = 0; c < 3; ++c) At(f, place.nodes[n]).v[c] += place.weights[n] * force[c];
    }
  }
  return true;
}

Eigen::Vector3d ContactSet::Mean(std::size_t k, const NodeVector& u) const noexcept {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const Place& place = places_[k];
  for (std::size_t n = 0; n < place.nodes.size(); ++n) {
    for (int c = 0; c < 3; ++c) mean[c] += place.weights[n] * At(u, place.nodes[n]).v[c];
  }
  return mean;
}

}  // namespace palpate::fem
