#include "slave/mechanics/capacitance/contact_set.h"

#include <algorithm>

#include "shared/geometry/index.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {
namespace {

// Basis components of the displacement at `at` by the weighted load.
void AddToUnknown(const ForceUnknown& at, const double* column, double weight, double* row,
                  long stride) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int a = 0; a < at.share_count; ++a) {
    const auto& share = at.shares[Index(a)];
    sum += weight * share.weight * BlockAt(column, share.place);
  }
  for (int k = 0; k < at.count; ++k) {
    for (int c = 0; c < 3; ++c) row[c * stride + at.row + k] += at.basis.col(k).dot(sum.col(c));
  }
}

// Displacement of a loaded place by the unknown's unit components.
void AddToLoad(const ForceUnknown& by, int place, double weight, double* row, long stride) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int b = 0; b < by.share_count; ++b) {
    const auto& share = by.shares[Index(b)];
    sum += weight * share.weight * BlockAt(share.column, place);
  }
  for (int k = 0; k < by.count; ++k) {
    for (int c = 0; c < 3; ++c) row[c * stride + by.row + k] += sum.row(c).dot(by.basis.col(k));
  }
}

}  // namespace

constexpr double kOnEdge = 1e-9;  // barycentric weight
constexpr std::string_view kInnerNode = "a node inside the body is not on its surface";

ContactSet::Outcome ContactSet::Fail(std::string_view why) {
  if (failure_.empty()) failure_ = why;
  known_ = false;
  return Outcome::kFailed;
}

ContactSet::Outcome ContactSet::Update(std::span<const Contact> contacts) {
  failure_ = {};
  changes_.clear();
  if (crowded_ && !IsSame(contacts)) known_ = false;  // there may be room again
  bool anew = !known_;
  if (anew) count_ = 0;
  bool found = contacts.size() == Count() ? FindChanged(contacts) : FindSpliced(contacts);
  if (found && changes_.empty() && !anew) return Outcome::kSame;
  crowded_ = found && IsCrowded();
  if (crowded_) {
    anew = true;
    found = FindAsTheyAre(contacts);
  }
  if (!found) return Fail("no boundary point is there");
  known_ = true;
  if (!Number()) return Fail("no Green's functions are known there");
  return anew ? Outcome::kRestarted : Outcome::kChanged;
}

bool ContactSet::IsSame(std::span<const Contact> contacts) const {
  return std::ranges::equal(slots(), contacts, [](const ContactSlot& slot, const Contact& contact) {
    return slot.contact.IsAt(contact);
  });
}

// What a disc does to others nearer than its own width depends on how wide it is.
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
  changes_.clear();
  places_.MayWiden(false);
  const bool found = FindSpliced(contacts);
  places_.MayWiden(true);
  return found;
}

// Contacts that moved, each by itself.
bool ContactSet::FindChanged(std::span<const Contact> contacts) {
  for (int i = 0; i < count_; ++i) {
    ContactSlot& slot = slots_[Index(i)];
    if (slot.contact.IsAt(contacts[Index(i)])) continue;
    changes_.push_back({.removed = slot.rows, .slot = i, .slots = 1});
    if (!Find(contacts[Index(i)], &slot)) return false;
  }
  return true;
}

// Contacts that came or went: everything between the common beginning and the common end.
bool ContactSet::FindSpliced(std::span<const Contact> contacts) {
  const int now = static_cast<int>(contacts.size());
  const int shorter = std::min(now, count_);
  int begin = 0, end = 0;
  while (begin < shorter && slots_[Index(begin)].contact.IsAt(contacts[Index(begin)])) ++begin;
  while (end < shorter - begin &&
         slots_[Index(count_ - 1 - end)].contact.IsAt(contacts[Index(now - 1 - end)])) {
    ++end;
  }
  Change change{.slot = begin, .slots = now - end - begin};
  for (int i = begin; i < count_ - end; ++i) change.removed += slots_[Index(i)].rows;
  changes_.push_back(change);
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
  if (slot->footprint.places.size() > most_places_) {
    most_places_ = slot->footprint.places.size();
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
    slot.row = rows_;
    slot.held = {};
    slot.on_support = false;
    slot.load = slot.contact.kind == Contact::Kind::kForce ? loads_++ : -1;
    if (slot.load < 0) {
      const std::span<const PlaceWeight> places = slot.footprint.places;
      if (slot.footprint.point) {
        if (!AddUnknown(places, &slot)) return false;
      } else {
        for (std::size_t p = 0; p < places.size(); ++p) {
          if (!AddUnknown(places.subspan(p, 1), &slot)) return false;
        }
      }
      if (!MarkMoved(slot)) return false;
    }
    slot.unknowns = static_cast<int>(unknowns_.size()) - slot.unknown;
    slot.rows = rows_ - slot.row;
  }
  for (const auto& slot : slots()) {
    if (slot.load >= 0 && LiesUnderContacts(slot)) {
      return Refuse("a load lies completely under contacts with a prescribed displacement");
    }
  }
  for (auto& change : changes_) {
    const auto touched = slots().subspan(Index(change.slot), Index(change.slots));
    const bool behind = change.slot == count_;
    change.row = behind ? rows_ : slots_[Index(change.slot)].row;
    change.unknown =
        behind ? static_cast<int>(unknowns_.size()) : slots_[Index(change.slot)].unknown;
    for (const auto& slot : touched) {
      change.inserted += slot.rows;
      change.unknowns += slot.unknowns;
    }
  }
  return true;
}

bool ContactSet::AddUnknown(std::span<const PlaceWeight> places, ContactSlot* slot) {
  ForceUnknown& unknown = unknowns_.emplace_back();
  unknown.row = rows_;
  unknown.share_count = static_cast<int>(places.size());
  const bool alone = places.size() == 1;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const double* column = compliance_.Column(places[p].place);
    if (column == nullptr) {
      return Refuse(
          "the Green's functions of a contact point are not stored: their memory is used up");
    }
    unknown.shares[p] = {column, places[p].place, alone ? 1 : places[p].weight};
  }
  double free_weight = 0;
  for (const auto& share : std::span(unknown.shares).first(places.size())) {
    const bool moves = BlockAt(share.column, share.place).diagonal().maxCoeff() > 0;
    free_weight += moves ? share.weight : 0;
  }
  slot->on_support = !alone && free_weight < kLeastFreeWeight;
  Eigen::Matrix3d self;
  if (!SelfBlock(unknown, &self)) return false;
  const Eigen::Array3d free(self(0, 0) > 0 ? 1 : 0, self(1, 1) > 0 ? 1 : 0, self(2, 2) > 0 ? 1 : 0);
  if (law_ == ContactLaw::kFrictionless) {
    if (slot->footprint.normal_O.isZero(0)) return Refuse("the surface has no normal there");
    unknown.basis.col(0) = slot->footprint.normal_O.array() * free;
    unknown.count = unknown.basis.col(0).isZero(0) ? 0 : 1;
  } else if (free.minCoeff() == 0) {
    unknown.count = 0;
    for (int c = 0; c < 3; ++c) {
      if (free[c] > 0) unknown.basis.col(unknown.count++) = Eigen::Vector3d::Unit(c);
    }
  }
  unknown.plain = alone && unknown.count == 3;
  for (int c = 0; c < 3; ++c) slot->held[Index(c)] = slot->held[Index(c)] || free[c] == 0;
  rows_ += unknown.count;
  if (unknown.count == 0) unknowns_.pop_back();
  return true;
}

bool ContactSet::SelfBlock(const ForceUnknown& unknown, Eigen::Matrix3d* block) {
  if (unknown.share_count > 1) {
    *block = FullBlock(unknown, unknown);
  } else {
    Touched& touched = touched_[Index(unknown.shares[0].place)];
    if (!touched.known) {
      touched.self = BlockAt(unknown.shares[0].column, unknown.shares[0].place);
      touched.known = true;
    }
    *block = touched.self;
  }
  const bool good = (*block)(0, 0) >= 0 && (*block)(1, 1) >= 0 && (*block)(2, 2) >= 0;
  return good || Refuse("the compliance of a contact point is not positive");
}

// Places with an unknown of their own cannot be moved twice.
bool ContactSet::MarkMoved(const ContactSlot& slot) {
  const auto& places = slot.footprint.places;
  if (slot.footprint.point && places.size() > 1) return true;
  for (const auto& [place, weight] : places) {
    int& set = touched_[Index(place)].set;
    if (set == set_) return Refuse("two contacts overlap: they share a boundary point");
    set = set_;
  }
  return true;
}

bool ContactSet::LiesUnderContacts(const ContactSlot& load) const {
  return std::ranges::all_of(load.footprint.places, [&](const PlaceWeight& share) {
    return touched_[Index(share.place)].set == set_;
  });
}

std::string_view SurfaceNodePlaces::Find(const Contact& contact, ContactFootprint* footprint) {
  const std::string_view refusal = footprints_.OnNodes(contact, footprint);
  if (!refusal.empty()) return refusal;
  const auto at = [this](int node) { return place_of_node_[Index(node)]; };
  if (footprint->at.node >= 0 && at(footprint->at.node) < 0) return kInnerNode;
  if (footprint->places.size() == 3) {  // a point on an edge
    std::erase_if(footprint->places, [](const PlaceWeight& p) { return p.weight <= kOnEdge; });
  }
  for (PlaceWeight& touched : footprint->places) touched.place = at(touched.place);
  const bool met = std::ranges::all_of(
      footprint->places, [](int p) { return p >= 0; }, &PlaceWeight::place);
  return met ? std::string_view{} : kInnerNode;
}

bool LoadCoupling::Fill(const ContactSet& set, int padded_rows) {
  loads_ = set.loads();
  if (loads_ == 0) return true;
  stride_ = padded_rows;
  const auto size = static_cast<std::size_t>(3 * loads_ * stride_);
  if (size > room_) {
    room_ = size + size / 2;
    by_ = MakeAligned(room_);
    if (!compliance_.symmetric()) at_ = MakeAligned(room_);
  }
  std::fill_n(by_.get(), size, 0.0);
  if (!compliance_.symmetric()) std::fill_n(at_.get(), size, 0.0);
  between_.assign(Index(loads_ * loads_), Eigen::Matrix3d::Zero());
  for (const auto& load : set.slots()) {
    if (load.load < 0) continue;
    const long first = 3 * load.load * stride_;
    for (const auto& [place, weight] : load.footprint.places) {
      const double* column = compliance_.Column(place);
      if (column == nullptr) return false;
      for (const auto& unknown : set.unknowns()) {
        AddToUnknown(unknown, column, weight, by_.get() + first, stride_);
        if (!compliance_.symmetric()) AddToLoad(unknown, place, weight, at_.get() + first, stride_);
      }
      for (const auto& other : set.slots()) {
        if (other.load < 0) continue;
        auto& block = between_[Index(other.load * loads_ + load.load)];
        for (const auto& at : other.footprint.places) {
          block += weight * at.weight * BlockAt(column, at.place);
        }
      }
    }
  }
  return true;
}

}  // namespace palpate
