#include "slave/mechanics/bem/moving_contacts.h"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// An update of one contact against a factorisation, as measured: kUpdates * changes against the
// number of contacts.
constexpr double kUpdates = 4;

// A block of E, column-major, into two rows of the matrix.
void CopyBlock(const double* e, double* first, double* second) {
  first[0] = e[0];
  first[1] = e[2];
  second[0] = e[1];
  second[1] = e[3];
}

}  // namespace

MovingContacts::MovingContacts(const GreensFunctions& greens)
    : greens_(greens),
      nodes_per_patch_(greens.element_nodes().count),
      slot_at_(greens.problem().mesh.elements.size(), -1) {
  free_elements_ = static_cast<std::size_t>(
      std::ranges::count(greens.problem().held, std::array<bool, 2>{false, false}));
}

// Displacements on the whole boundary are CapacitanceSolver's to judge.
bool MovingContacts::Suits(std::span<const ContactPatch> patches) const noexcept {
  if (patches.size() < kFewest || patches.size() >= free_elements_) return false;
  if (greens_.free_motions() > 0) return false;
  const auto law = patches.front().law;
  return std::ranges::all_of(patches, [&](const ContactPatch& patch) {
    const int node = patch.nodes.front();
    return patch.law == law && law != ContactPatch::Law::kLoad &&
           patch.nodes.size() == Index(nodes_per_patch_) && !greens_.held(node, 0) &&
           !greens_.held(node, 1);
  });
}

bool MovingContacts::Prepare(std::span<const ContactPatch> patches) {
  if (!Suits(patches)) {
    if (!slots_.empty()) Forget();
    return false;
  }
  const int components = patches.front().law == ContactPatch::Law::kBonded ? 2 : 1;
  if (components != components_) Forget();
  components_ = components;
  int missing = 0;
  if (!Match(patches, &missing)) {
    Forget();
    return false;
  }
  const auto gone = static_cast<int>(slots_.size() + Index(missing) - patches.size());
  const bool few = kUpdates * (missing + gone) < static_cast<double>(patches.size());
  if (!(few && inverse_.inverted() && Update(patches)) && !Rebuild(patches, few)) {
    Forget();
    return false;
  }
  if (inverse_.padded() > room_) {
    room_ = inverse_.padded() + inverse_.padded() / 4;
    moved_ = MakeAligned(Index(room_));
    tractions_ = MakeAligned(Index(room_));
  }
  std::fill_n(moved_.get(), inverse_.padded(), 0.0);
  return true;
}

// Finds the patches' slots. False: two on one element.
bool MovingContacts::Match(std::span<const ContactPatch> patches, int* missing) {
  ++set_;
  slot_of_.assign(patches.size(), -1);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const int slot = slot_at_[Index(greens_.node(patches[p].nodes.front()).element)];
    if (slot < 0 || slots_[Index(slot)].direction != patches[p].direction) {
      ++*missing;
      continue;
    }
    if (slots_[Index(slot)].set == set_) return false;
    slots_[Index(slot)].set = set_;
    slot_of_[p] = slot;
  }
  return true;
}

bool MovingContacts::Update(std::span<const ContactPatch> patches) {
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (slot_of_[p] < 0) Fetch(patches[p], patches);
  }
  if (!MakeRoom(patches)) return false;
  const int count = static_cast<int>(slots_.size());
  for (int slot = 0; slot < count; ++slot) {
    if (slots_[Index(slot)].fresh) FillBlocks(slot, count);
  }
  for (int slot = 0; slot < count; ++slot) {
    if (!slots_[Index(slot)].fresh) continue;
    if (!inverse_.Border(slot * block(), block())) return false;
    slots_[Index(slot)].fresh = false;
  }
  const long before = inverse_.inversions();
  const bool good = inverse_.Settle();
  counts_.factorisations += inverse_.inversions() - before;
  return good;
}

// New patches take the slots of those that are gone; what is left over of either is put in at the
// end or taken out.
bool MovingContacts::MakeRoom(std::span<const ContactPatch> patches) {
  for (const auto& slot : slots_) {
    if (slot.set != set_) SlotAt(slot) = -1;
  }
  std::size_t p = 0;
  const auto find_new = [&] {
    while (p < patches.size() && slot_of_[p] >= 0) ++p;
    return p < patches.size();
  };
  for (int slot = static_cast<int>(slots_.size()); slot-- > 0;) {
    if (slots_[Index(slot)].set == set_) continue;
    const bool replaced = find_new();
    if (!inverse_.Splice(slot * block(), block(), replaced ? block() : 0)) return false;
    counts_.updates += replaced ? 2 : 1;
    if (!replaced) {
      Erase(slot);
    } else if (!Assign(patches[p], p, slot)) {
      return false;
    }
  }
  while (find_new()) {
    slots_.emplace_back();
    ++counts_.updates;
    const int slot = static_cast<int>(slots_.size()) - 1;
    if (!inverse_.Splice(slot * block(), 0, block()) || !Assign(patches[p], p, slot)) return false;
  }
  return true;
}

void MovingContacts::Erase(int slot) {
  slots_.erase(slots_.begin() + slot);
  for (int& s : slot_of_) s -= s > slot;
  for (const auto& s : slots_) {
    if (s.set == set_) SlotAt(s) -= SlotAt(s) > slot;
  }
}

// The inverse where few contacts changed, so that the next change, which may be as small, finds it.
bool MovingContacts::Rebuild(std::span<const ContactPatch> patches, bool few_changed) {
  Forget();
  ++set_;
  slot_of_.assign(patches.size(), -1);
  slots_.resize(patches.size());
  inverse_.Reset(static_cast<int>(patches.size()) * block());
  for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
    const std::size_t next = Index(p) + 1;
    if (next < patches.size()) Fetch(patches[next], patches.first(next + 1));
    if (!Assign(patches[Index(p)], Index(p), p)) return false;
    FillBlocks(p, p + 1);
    slots_[Index(p)].fresh = false;
  }
  ++counts_.factorisations;
  return few_changed ? inverse_.Invert() : inverse_.Factorise();
}

void MovingContacts::Forget() {
  for (const auto& slot : slots_) SlotAt(slot) = -1;
  slots_.clear();
  inverse_.Reset(0);
}

// False: another one is on the same element.
bool MovingContacts::Assign(const ContactPatch& patch, std::size_t patch_index, int slot) {
  slots_[Index(slot)] = {patch.nodes.front(), patch.direction, set_, true};
  int& at = SlotAt(slots_[Index(slot)]);
  if (at >= 0) return false;
  at = slot_of_[patch_index] = slot;
  return true;
}

// What two slots' nodes do to each other, into the matrix's rows of `to` and columns of `from`.
void MovingContacts::FillBlock(const Slot& to, int row, const Slot& from, int column) {
  for (int a = 0; a < nodes_per_patch_; ++a) {
    for (int b = 0; b < nodes_per_patch_; ++b) {
      const double* e = greens_.block(to.first_node + a, from.first_node + b);
      double* first = inverse_.row(row + a * components_) + column + b * components_;
      if (components_ == 1) {
        *first = to.direction.dot(Eigen::Map<const Matrix2d>(e) * from.direction);
        continue;
      }
      CopyBlock(e, first, inverse_.row(row + a * 2 + 1) + column + b * 2);
    }
  }
}

// A slot's rows and columns beside the first `others` slots; two components of one node, the common
// case, in one go.
void MovingContacts::FillBlocks(int slot, int others) {
  const Slot& own = slots_[Index(slot)];
  const int first = slot * block();
  if (components_ == 2 && nodes_per_patch_ == 1) {
    for (int at = 0; at < 2 * others; at += 2) {
      const int other = slots_[Index(at / 2)].first_node;
      CopyBlock(greens_.block(other, own.first_node), inverse_.row(at) + first,
                inverse_.row(at + 1) + first);
      CopyBlock(greens_.block(own.first_node, other), inverse_.row(first) + at,
                inverse_.row(first + 1) + at);
    }
    return;
  }
  for (int other = 0; other < others; ++other) {
    FillBlock(slots_[Index(other)], other * block(), own, first);
    FillBlock(own, first, slots_[Index(other)], other * block());
  }
}

// Asks for what FillBlocks will read: at random places of a large matrix, all on their way at once.
void MovingContacts::Fetch(const ContactPatch& patch, std::span<const ContactPatch> others) const {
  for (const auto& other : others) {
    for (const int a : patch.nodes) {
      for (const int b : other.nodes) {
        __builtin_prefetch(greens_.block(a, b));
        __builtin_prefetch(greens_.block(b, a));
      }
    }
  }
}

// `moved` and `tractions`: as UpdatedInverse::Solve wants them.
void MovingContacts::SolveTractions(std::span<const double> prescribed, double* moved,
                                    double* tractions) const noexcept {
  for (std::size_t p = 0; p < slot_of_.size(); ++p) {
    const Slot& slot = slots_[Index(slot_of_[p])];
    const Vector2d value(prescribed[2 * p], prescribed[2 * p + 1]);
    for (int k = 0; k < block(); ++k) {
      moved[slot_of_[p] * block() + k] = Basis(slot, k % components_).dot(value);
    }
  }
  inverse_.Solve(moved, tractions);
}

void MovingContacts::Respond(std::span<const double> prescribed,
                             std::span<double> answer) noexcept {
  SolveTractions(prescribed, moved_.get(), tractions_.get());
  for (std::size_t p = 0; p < slot_of_.size(); ++p) {
    const Slot& slot = slots_[Index(slot_of_[p])];
    Vector2d force = Vector2d::Zero();
    for (int k = 0; k < block(); ++k) {
      force += greens_.lengths()[Index(slot.first_node + k / components_)] *
               tractions_[Index(slot_of_[p] * block() + k)] * Basis(slot, k % components_);
    }
    answer[2 * p] = force.x();
    answer[2 * p + 1] = force.y();
  }
}

Matrix2d MovingContacts::Derivative(int patch) noexcept {
  const int first = slot_of_[Index(patch)] * block();
  const Slot& slot = slots_[Index(slot_of_[Index(patch)])];
  inverse_.PrepareBlocks();
  Matrix2d derivative = Matrix2d::Zero();
  for (int r = 0; r < block(); ++r) {
    const double length = greens_.lengths()[Index(slot.first_node + r / components_)];
    for (int c = 0; c < block(); ++c) {
      derivative(r % components_, c % components_) += length * inverse_.Entry(first + r, first + c);
    }
  }
  if (components_ == 2) return derivative;
  return derivative(0, 0) * slot.direction * slot.direction.transpose();
}

void MovingContacts::Boundary(std::span<const double> prescribed,
                              std::vector<Vector2d>* displacement,
                              std::vector<Vector2d>* traction) const {
  const auto moved = MakeAligned(Index(inverse_.padded()));
  const auto tractions = MakeAligned(Index(inverse_.padded()));
  SolveTractions(prescribed, moved.get(), tractions.get());
  BoundarySum sum(greens_);
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    for (int k = 0; k < block(); ++k) {
      sum.Add(slots_[s].first_node + k / components_,
              tractions[s * Index(block()) + Index(k)] * Basis(slots_[s], k % components_));
    }
  }
  sum.Finish(displacement, traction);
}

}  // namespace palpate
