#include "slave/mechanics/capacitance/contact_set.h"

#include <algorithm>

#include "slave/mechanics/footprint/rim_share.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

constexpr double kOnEdge = 1e-9;  // barycentric weight
constexpr double kRim = 0.5;      // share under a flat face
constexpr std::string_view kInnerNode = "a node inside the body is not on its surface";
constexpr std::string_view kNotStored =
    "the Green's functions of a contact point are not stored: their memory is used up";

// Returns whether the slot has the contact's place and all places that it may touch there.
bool Covers(const ContactSlot& slot, const Contact& contact) {
  if (!slot.contact.IsAt(contact)) return false;
  return !slot.is_tool() || contact.radius == 0 ||
         -slot.footprint.normal_O.dot(contact.prescribed_O) <= slot.footprint.depth;
}

}  // namespace

ContactSet::Outcome ContactSet::Fail(std::string_view why) {
  if (failure_.empty()) failure_ = why;
  known_ = false;
  return Outcome::kFailed;
}

ContactSet::Outcome ContactSet::Update(std::span<const Contact> contacts) {
  failure_ = {};
  if (known_ && IsSame(contacts)) return Outcome::kSame;
  if (crowded_) known_ = false;  // a wider disc may be possible again
  if (!known_) count_ = 0;
  bool found = contacts.size() == Count() ? FindChanged(contacts) : FindSpliced(contacts);
  crowded_ = found && IsCrowded();
  if (crowded_) found = FindAsTheyAre(contacts);
  if (!found) return Fail("no boundary point is there");
  known_ = true;
  if (!Number()) return Fail("no Green's functions are known there");
  return Outcome::kChanged;
}

bool ContactSet::IsSame(std::span<const Contact> contacts) const {
  return std::ranges::equal(slots(), contacts, [](const ContactSlot& slot, const Contact& contact) {
    return Covers(slot, contact);
  });
}

// The effect of a disc on contacts nearer than its own width depends on that width.
bool ContactSet::IsCrowded() const {
  for (const auto& wide : slots()) {
    if (wide.footprint.reach == 0) continue;
    for (const auto& other : slots()) {
      const double own = std::max(other.footprint.reach, other.contact.width / 2);
      const double distance = (wide.contact.p_O - other.contact.p_O).norm();
      if (&other != &wide && distance < 2 * wide.footprint.reach + own) return true;
    }
  }
  return false;
}

bool ContactSet::FindAsTheyAre(std::span<const Contact> contacts) {
  count_ = 0;
  places_.MayWiden(false);
  const bool found = FindSpliced(contacts);
  places_.MayWiden(true);
  return found;
}

// Finds the contacts that moved, if their number is unchanged.
bool ContactSet::FindChanged(std::span<const Contact> contacts) {
  for (int i = 0; i < count_; ++i) {
    ContactSlot& slot = slots_[Index(i)];
    if (Covers(slot, contacts[Index(i)])) continue;
    if (!Find(contacts[Index(i)], &slot)) return false;
  }
  return true;
}

// Updates added and removed contacts: all between the common beginning and the common end of both
// lists.
bool ContactSet::FindSpliced(std::span<const Contact> contacts) {
  const int now = static_cast<int>(contacts.size());
  const int shorter = std::min(now, count_);
  int begin = 0, end = 0;
  while (begin < shorter && Covers(slots_[Index(begin)], contacts[Index(begin)])) ++begin;
  while (end < shorter - begin &&
         Covers(slots_[Index(count_ - 1 - end)], contacts[Index(now - 1 - end)])) {
    ++end;
  }
  if (slots_.size() < contacts.size()) {
    slots_.resize(contacts.size());
    MakeRoom();
  }
  const auto first = slots_.begin() + begin;
  const auto last = slots_.begin() + std::max(now, count_);
  std::rotate(first, now > count_ ? last - (now - count_) : first + (count_ - now), last);
  count_ = now;
  for (int i = begin; i < now - end; ++i) {
    if (!Find(contacts[Index(i)], &slots_[Index(i)])) return false;
  }
  return true;
}

bool ContactSet::Find(const Contact& contact, ContactSlot* slot) {
  slot->contact = contact;
  slot->footprint.places.clear();
  failure_ = places_.Find(contact, &slot->footprint);
  if (slot->footprint.places.size() > max_places_) {
    max_places_ = slot->footprint.places.size();
    MakeRoom();
  }
  return failure_.empty() && !slot->footprint.places.empty();
}

// Unknown components row by row, in the order of the contacts.
bool ContactSet::Number() {
  ++set_;
  rows_ = 0;
  loads_ = 0;
  unknowns_.clear();
  for (auto& slot : std::span(slots_.data(), Count())) {
    slot.unknown = static_cast<int>(unknowns_.size());
    slot.held = {};
    slot.on_support = false;
    slot.load = slot.contact.kind == Contact::Kind::kForce ? loads_++ : -1;
    if (!(slot.load < 0 ? AddUnknowns(&slot) : FindHeld(&slot))) return false;
    slot.unknowns = static_cast<int>(unknowns_.size()) - slot.unknown;
  }
  for (const auto& slot : slots()) {
    if (slot.load >= 0 && LiesUnderContacts(slot)) {
      return Refuse("a load lies completely under contacts with a prescribed displacement");
    }
  }
  if (rows_ > 0) AddMotions();
  return true;
}

// Finds components that a load cannot move.
bool ContactSet::FindHeld(ContactSlot* slot) {
  slot->held = {true, true, true};
  for (const PlaceWeight& loaded : slot->footprint.places) {
    if (compliance_.Column(loaded.place) == nullptr) return Refuse(kNotStored);
    const std::array<bool, 3> fixed = compliance_.Held(loaded.place);
    for (std::size_t c = 0; c < 3; ++c) slot->held[c] = slot->held[c] && fixed[c];
  }
  return true;
}

// A node of which the smaller part lies under a flat face, and which a support holds: it stays.
bool ContactSet::IsHeldRim(const PlaceWeight& at, const ToolHold& hold) {
  if (hold.share >= kRim || compliance_.Column(at.place) == nullptr) return false;
  const std::array<bool, 3> held = compliance_.Held(at.place);
  return held[0] || held[1] || (held[2] && compliance_.components() == 3);
}

bool ContactSet::AddUnknowns(ContactSlot* slot) {
  const std::span<const PlaceWeight> places = slot->footprint.places;
  if (slot->footprint.point) {
    if (!AddUnknown(places, slot)) return false;
  } else {
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (slot->is_tool() && IsHeldRim(places[p], slot->footprint.holds[p])) continue;
      const std::size_t before = unknowns_.size();
      if (!AddUnknown(places.subspan(p, 1), slot)) return false;
      if (slot->is_tool() && unknowns_.size() > before) unknowns_.back().hold = static_cast<int>(p);
    }
  }
  return MarkMoved(*slot);
}

bool ContactSet::AddUnknown(std::span<const PlaceWeight> places, ContactSlot* slot) {
  ForceUnknown& unknown = unknowns_.emplace_back();
  unknown.row = rows_;
  unknown.share_count = static_cast<int>(places.size());
  unknown.measure = compliance_.measure(places[0].place);
  const bool alone = places.size() == 1;
  double free_weight = 0;
  std::array<bool, 3> held{true, true, true};
  for (std::size_t p = 0; p < places.size(); ++p) {
    const double* column = compliance_.Column(places[p].place);
    if (column == nullptr) return Refuse(kNotStored);
    unknown.shares[p] = {column, places[p].place, alone ? 1 : places[p].weight};
    const std::array<bool, 3> fixed = compliance_.Held(places[p].place);
    if (!(fixed[0] && fixed[1] && fixed[2])) free_weight += places[p].weight;
    for (std::size_t c = 0; c < 3; ++c) held[c] = held[c] && fixed[c];
  }
  slot->on_support = !alone && free_weight < kMinFreeWeight;
  if (law_ == ContactLaw::kFrictionless) {
    if (slot->footprint.normal_O.isZero(0)) return Refuse("the surface has no normal there");
    unknown.basis.col(0) = slot->footprint.normal_O;
    for (int c = 0; c < 3; ++c) {
      if (held[Index(c)]) unknown.basis(c, 0) = 0;
    }
    unknown.count = unknown.basis.col(0).isZero(0) ? 0 : 1;
  } else {
    unknown.count = 0;
    for (int c = 0; c < 3; ++c) {
      if (!held[Index(c)]) unknown.basis.col(unknown.count++) = Eigen::Vector3d::Unit(c);
    }
  }
  unknown.plain = alone && unknown.count == compliance_.components();
  for (std::size_t c = 0; c < 3; ++c) slot->held[c] = slot->held[c] || held[c];
  rows_ += unknown.count;
  if (unknown.count == 0) unknowns_.pop_back();
  return true;
}

void ContactSet::AddMotions() {
  for (int k = 0; k < compliance_.motions(); ++k) {
    const int place = compliance_.places() + k;
    ForceUnknown& motion = unknowns_.emplace_back();
    motion.shares[0] = {compliance_.Column(place), place, 1};
    motion.share_count = 1;
    motion.row = rows_;
    motion.count = compliance_.components();
    motion.plain = true;
    rows_ += motion.count;
  }
}

// A place with its own unknown cannot be moved by two contacts, unless flat faces have parts of it
// that do not overlap: each then pushes it through its own spring.
bool ContactSet::MarkMoved(const ContactSlot& slot) {
  const auto& places = slot.footprint.places;
  if (slot.footprint.point && places.size() > 1) return true;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const std::size_t place = Index(places[p].place);
    const double before = moved_by_[place] == set_ ? moved_share_[place] : 0;
    const double share = slot.is_tool() ? slot.footprint.holds[p].share : 1;
    if (before > 0 && !(before + share <= kWholeShare)) {
      return Refuse("two contacts overlap: they share a boundary point");
    }
    moved_by_[place] = set_;
    moved_share_[place] = before + share;
  }
  return true;
}

bool ContactSet::LiesUnderContacts(const ContactSlot& load) const {
  return std::ranges::all_of(load.footprint.places, [&](const PlaceWeight& share) {
    return moved_by_[Index(share.place)] == set_;
  });
}

std::string_view SurfaceNodePlaces::Find(const Contact& contact, ContactFootprint* footprint) {
  const std::string_view refusal = IsTool(contact) ? footprints_.OnTool(contact, false, footprint)
                                                   : footprints_.OnNodes(contact, footprint);
  if (!refusal.empty()) return refusal;
  const auto at = [this](int node) { return place_of_node_[Index(node)]; };
  if (footprint->at.node >= 0 && at(footprint->at.node) < 0) return kInnerNode;
  if (footprint->point && footprint->places.size() == 3) {  // a point on an edge
    std::erase_if(footprint->places, [](const PlaceWeight& p) { return p.weight <= kOnEdge; });
  }
  for (PlaceWeight& touched : footprint->places) touched.place = at(touched.place);
  const bool met = std::ranges::all_of(
      footprint->places, [](int p) { return p >= 0; }, &PlaceWeight::place);
  return met ? std::string_view{} : kInnerNode;
}

void LoadCoupling::Fill(const ContactSet& set) {
  loads_ = set.loads();
  if (loads_ == 0) return;
  rows_ = set.rows();
  for (auto* rows : {&by_, &at_}) rows->assign(Index(3 * loads_) * Index(rows_), 0.0);
  between_.assign(Index(loads_ * loads_), Eigen::Matrix3d::Zero());
  for (const auto& load : set.slots()) {
    if (load.load < 0) continue;
    for (const auto& [place, weight] : load.footprint.places) {
      const double* column = compliance_.Column(place);
      const double amplitude = weight / compliance_.measure(place);
      for (const auto& unknown : set.unknowns()) {
        AddToUnknown(unknown, column, place, amplitude, load.load);
        AddToLoad(unknown, place, weight, load.load);
      }
      for (const auto& other : set.slots()) {
        if (other.load < 0) continue;
        auto& block = between_[Index(other.load * loads_ + load.load)];
        for (const auto& at : other.footprint.places) {
          block += amplitude * at.weight * compliance_.FreeBlock(column, place, at.place);
        }
      }
    }
  }
}

// Basis components of the displacement at `at` by the weighted load.
void LoadCoupling::AddToUnknown(const ForceUnknown& at, const double* column, int place,
                                double weight, int load) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& share : std::span(at.shares).first(Index(at.share_count))) {
    sum += weight * share.weight * compliance_.FreeBlock(column, place, share.place);
  }
  for (int c = 0; c < 3; ++c) {
    double* row = by_.data() + Index(3 * load + c) * Index(rows_) + at.row;
    for (int k = 0; k < at.count; ++k) row[k] += at.basis.col(k).dot(sum.col(c));
  }
}

// Adds the displacement of a loaded place for unit components of the unknown.
void LoadCoupling::AddToLoad(const ForceUnknown& by, int place, double weight, int load) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& share : std::span(by.shares).first(Index(by.share_count))) {
    sum += weight * share.weight * compliance_.FreeBlock(share.column, share.place, place);
  }
  for (int c = 0; c < 3; ++c) {
    double* row = at_.data() + Index(3 * load + c) * Index(rows_) + by.row;
    for (int k = 0; k < by.count; ++k) row[k] += sum.row(c).dot(by.basis.col(k));
  }
}

}  // namespace palpate
