#include "slave/mechanics/fem/contact_set.h"

#include <algorithm>
#include <cmath>

#include "slave/mechanics/mesh_resolution.h"

namespace palpate::fem {
namespace {

bool Finite(const Contact& contact) {
  return contact.p_O.allFinite() && contact.prescribed_O.allFinite() &&
         std::isfinite(contact.width) && contact.width >= 0;
}

}  // namespace

ContactSet::ContactSet(const SolidMesh& mesh, const FemBody& body)
    : body_(body), footprints_(SurfaceOf(mesh)) {}

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
  Contact anywhere = contact;
  anywhere.element = -1;  // its place counts alone
  if (!footprints_.OnNodes(anywhere, &footprint_).empty()) return "no node or surface is there";
  const bool holds = contact.kind == Contact::Kind::kDisplacement;
  place.point = footprint_.point && footprint_.places.size() > 1;
  place.coarse = footprint_.coarse;
  place.nodes.clear();
  double free_weight = 0;
  for (const auto& [node, weight] : footprint_.places) {
    const double* free = At(body_.free(), body_.Number(node)).v;
    free_weight += std::max({free[0], free[1], free[2]}) > 0 ? weight : 0;
    if (!(weight > 0) && !holds) continue;
    place.nodes.push_back({body_.Number(node), weight});
    if (body_.Volume(place.nodes.back().place) == 0) return "its node belongs to no element";
  }
  place.arms.clear();
  if (place.nodes.size() == footprint_.arms.size()) place.arms = footprint_.arms;
  place.on_support = holds && place.point && free_weight < kLeastFreeWeight;
  return nullptr;
}

bool ContactSet::Hold(const Place& place, Constraints& constraints) {
  const auto& n = place.nodes;
  if (place.point) {
    return constraints.HoldPoint({n[0].place, n[1].place, n[2].place},
                                 {n[0].weight, n[1].weight, n[2].weight});
  }
  held_.clear();
  for (const PlaceWeight& node : n) held_.push_back(node.place);
  return constraints.HoldNodes(held_);
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
    for (const auto& [node, weight] : place.nodes) {
      for (int c = 0; c < 3; ++c) At(f, node).v[c] += weight * force[c];
    }
  }
  return true;
}

Eigen::Vector3d ContactSet::Mean(std::size_t k, const NodeVector& u) const noexcept {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& [node, weight] : places_[k].nodes) {
    for (int c = 0; c < 3; ++c) mean[c] += weight * At(u, node).v[c];
  }
  return mean;
}

}  // namespace palpate::fem
