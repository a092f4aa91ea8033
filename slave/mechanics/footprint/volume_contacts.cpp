#include "slave/mechanics/footprint/volume_contacts.h"

#include <algorithm>
#include <cmath>

#include "slave/mechanics/mesh_resolution.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kAbsurd = 1e6;  // units
// Fraction of a contact's weight that may be on nodes moved by another contact.
constexpr double kMaxShared = 0.5;
constexpr std::size_t kTextSize = 240;  // of a failure

}  // namespace

VolumeContacts::VolumeContacts(const SolidMesh& mesh, int nodes_per_element, const HeldNodes& held,
                               double length_unit, double force_unit, bool finds_tools)
    : mesh_(MakeTetMesh(mesh, nodes_per_element, 1)),
      held_(HeldWithMiddles(mesh_, held)),
      used_(mesh_.nodes.size(), false),
      length_unit_(length_unit),
      force_unit_(force_unit),
      finds_tools_(finds_tools),
      footprints_(mesh_, 1, {}) {
  for (const int node : mesh_.connectivity) used_[Index(node)] = true;
  failure_.reserve(kTextSize);
}

bool VolumeContacts::Refuse(std::size_t contact, std::string_view why) {
  failure_.assign("contact ").append(std::to_string(contact)).append(": ").append(why);
  ready_ = false;
  return false;
}

bool VolumeContacts::Prepare(std::span<const Contact> contacts) {
  failure_.clear();
  const std::size_t known = ready_ ? contacts_.size() : 0;
  change_ = known == contacts.size() && ready_ ? Change::kNone : Change::kHolds;
  contacts_.resize(contacts.size());
  places_.resize(contacts.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const std::string_view wrong = FindSizes(contacts[k]);
    if (!wrong.empty()) return Refuse(k, wrong);
    if (k < known && IsKnown(k, contacts[k])) continue;
    const auto moves = Contact::Kind::kDisplacement;
    const bool holds = contacts[k].kind == moves || (k < known && contacts_[k].kind == moves);
    change_ = holds || change_ == Change::kHolds ? Change::kHolds : Change::kLoads;
    contacts_[k] = contacts[k];
    const std::string_view refusal = Find(contacts[k], &places_[k]);
    if (!refusal.empty()) return Refuse(k, refusal);
  }
  if (change_ != Change::kNone) {
    const int overlapping = Overlapping(contacts);
    if (overlapping >= 0) return Refuse(Index(overlapping), "it overlaps another contact");
  }
  ready_ = true;
  return true;
}

// Returns whether the places are also those of `now`: a round tool may have become deeper.
bool VolumeContacts::IsKnown(std::size_t contact, const Contact& now) const {
  if (!contacts_[contact].IsAt(now)) return false;
  const ContactPlace& place = places_[contact];
  return place.holds.empty() || now.radius == 0 ||
         -place.axis_O.dot(now.prescribed_O) <= place.depth;
}

std::string_view VolumeContacts::FindSizes(const Contact& contact) const {
  if (!contact.p_O.allFinite() || !contact.prescribed_O.allFinite() ||
      !std::isfinite(contact.width) || contact.width < 0 || !std::isfinite(contact.radius) ||
      contact.radius < 0) {
    return "a number is not finite, or the width or the radius is negative";
  }
  const bool force = contact.kind == Contact::Kind::kForce;
  if (contact.prescribed_O.norm() <= kAbsurd * (force ? force_unit_ : length_unit_)) return {};
  return force ? "the force is beyond a million times E times the larger side squared"
               : "the displacement is beyond a million times the larger side";
}

std::string_view VolumeContacts::Find(const Contact& contact, ContactPlace* place) {
  const bool is_tool = finds_tools_ && IsTool(contact);
  const std::string_view refusal = is_tool ? footprints_.OnTool(contact, true, &footprint_)
                                           : footprints_.OnNodes(contact, &footprint_);
  if (!refusal.empty()) return refusal;
  place->axis_O = footprint_.normal_O;
  place->depth = footprint_.depth;
  place->fewest = footprint_.fewest;
  place->holds = footprint_.holds;
  const bool holds = contact.kind == Contact::Kind::kDisplacement;
  place->is_point = footprint_.point && footprint_.places.size() > 1;
  place->patch_error = footprint_.patch_error;
  place->nodes.clear();
  double free_weight = 0;
  for (const PlaceWeight& touched : footprint_.places) {
    if (touched.weight == 0) continue;
    if (!used_[Index(touched.place)]) return "its node belongs to no element";
    const auto& held = held_[Index(touched.place)];
    free_weight += held[0] && held[1] && held[2] ? 0 : touched.weight;
    place->nodes.push_back(touched);
  }
  place->arms.clear();
  if (place->nodes.size() == footprint_.arms.size()) place->arms = footprint_.arms;
  place->on_support = holds && place->is_point && free_weight < kMinFreeWeight;
  return {};
}

// Returns the first contact that moves a node which another contact moves already, or that is a
// load or a point (at the rim of a neighbouring patch) with half or more of its weight on such
// nodes; -1: none.
int VolumeContacts::Overlapping(std::span<const Contact> contacts) {
  owner_.assign(mesh_.nodes.size(), -1);
  const auto moves_nodes = [&](std::size_t k) {
    return contacts[k].kind == Contact::Kind::kDisplacement && !places_[k].is_point;
  };
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (!moves_nodes(k)) continue;
    for (const PlaceWeight& node : places_[k].nodes) {
      if (owner_[Index(node.place)] >= 0) return static_cast<int>(k);
      owner_[Index(node.place)] = static_cast<int>(k);
    }
  }
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (moves_nodes(k)) continue;
    double shared = 0;
    for (const auto& [node, weight] : places_[k].nodes) {
      if (owner_[Index(node)] >= 0) shared += std::abs(weight);
    }
    if (shared >= kMaxShared) return static_cast<int>(k);
  }
  return -1;
}

}  // namespace palpate
