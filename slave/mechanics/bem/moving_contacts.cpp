#include "slave/mechanics/bem/moving_contacts.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "shared/geometry/index.h"
#include "slave/mechanics/bem/boundary_sum.h"

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
  moved_.assign(Index(PaddedTo(kLane, inverse_.order())), 0.0);
  tractions_.assign(moved_.size(), 0.0);
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
  for (int slot = static_cast<int>(slots_.size()); slot-- > 0;) {
    if (slots_[Index(slot)].set == set_) continue;
    if (!inverse_.Remove(slot)) return false;
    ++counts_.updates;
    slot_at_[Index(greens_.node(slots_[Index(slot)].first_node).element)] = -1;
    const int last = static_cast<int>(slots_.size()) - 1;
    if (slot != last) {
      slots_[Index(slot)] = slots_.back();
      slot_at_[Index(greens_.node(slots_[Index(slot)].first_node).element)] = slot;
      std::ranges::replace(slot_of_, last, slot);
    }
    slots_.pop_back();
  }
  inverse_.Reserve(static_cast<int>(patches.size()));
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (slot_of_[p] >= 0) continue;
    if (slot_at_[Index(greens_.node(patches[p].nodes.front()).element)] >= 0) return false;
    Add(patches[p], static_cast<int>(p));
    if (!inverse_.Append()) return false;
    ++counts_.updates;
  }
  drift_ = inverse_.Drift();
  if (drift_ <= kLargestDrift) return true;
  ++counts_.factorisations;
  return inverse_.Invert();
}

// The inverse where few contacts changed, so that the next change, which may be as small, finds it.
bool MovingContacts::Rebuild(std::span<const ContactPatch> patches, bool few_changed) {
  Forget();
  ++set_;
  slot_of_.assign(patches.size(), -1);
  inverse_.Reserve(static_cast<int>(patches.size()));
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (slot_at_[Index(greens_.node(patches[p].nodes.front()).element)] >= 0) return false;
    if (p + 1 < patches.size()) Fetch(patches[p + 1], patches.first(p + 2));
    Add(patches[p], static_cast<int>(p));
    inverse_.Extend();
  }
  ++counts_.factorisations;
  drift_ = 0;
  return few_changed ? inverse_.Invert() : inverse_.Factorise();
}

void MovingContacts::Forget() {
  for (const auto& slot : slots_) slot_at_[Index(greens_.node(slot.first_node).element)] = -1;
  slots_.clear();
  inverse_.Clear(components_ * nodes_per_patch_);
}

// As the next block of the matrix.
void MovingContacts::Add(const ContactPatch& patch, int patch_index) {
  const Slot slot{patch.nodes.front(), patch.direction, set_};
  slot_of_[Index(patch_index)] = static_cast<int>(slots_.size());
  slot_at_[Index(greens_.node(slot.first_node).element)] = slot_of_[Index(patch_index)];
  slots_.push_back(slot);
  FillBlocks(slot);
}

Vector2d MovingContacts::Basis(const Slot& slot, int k) const noexcept {
  return components_ == 1 ? slot.direction : Vector2d::Unit(k);
}

// What two slots' nodes do to each other, into the matrix's rows of `to` and columns of `from`.
void MovingContacts::FillBlock(const Slot& to, int row, const Slot& from, int column) {
  for (int a = 0; a < nodes_per_patch_; ++a) {
    for (int b = 0; b < nodes_per_patch_; ++b) {
      const double* e = greens_.block(to.first_node + a, from.first_node + b);
      double* first = inverse_.matrix_row(row + a * components_) + column + b * components_;
      if (components_ == 1) {
        *first = to.direction.dot(Eigen::Map<const Matrix2d>(e) * from.direction);
        continue;
      }
      CopyBlock(e, first, inverse_.matrix_row(row + a * 2 + 1) + column + b * 2);
    }
  }
}

// The last slot's rows and columns; two components of one node, the common case, in one go.
void MovingContacts::FillBlocks(const Slot& slot) {
  const int last = static_cast<int>(slots_.size() - 1) * block();
  if (components_ == 2 && nodes_per_patch_ == 1) {
    double* first = inverse_.matrix_row(last);
    double* second = inverse_.matrix_row(last + 1);
    for (int at = 0; at <= last; at += 2) {
      const int other = slots_[Index(at / 2)].first_node;
      CopyBlock(greens_.block(other, slot.first_node), inverse_.matrix_row(at) + last,
                inverse_.matrix_row(at + 1) + last);
      CopyBlock(greens_.block(slot.first_node, other), first + at, second + at);
    }
    return;
  }
  for (std::size_t other = 0; other + 1 < slots_.size(); ++other) {
    const int at = static_cast<int>(other) * block();
    FillBlock(slots_[other], at, slot, last);
    FillBlock(slot, last, slots_[other], at);
  }
  FillBlock(slot, last, slot, last);
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

// `moved` and `tractions`: as BlockInverse::Multiply wants them.
void MovingContacts::SolveTractions(std::span<const double> prescribed, double* moved,
                                    double* tractions) const noexcept {
  for (std::size_t p = 0; p < slot_of_.size(); ++p) {
    const Slot& slot = slots_[Index(slot_of_[p])];
    const Vector2d value(prescribed[2 * p], prescribed[2 * p + 1]);
    for (int k = 0; k < block(); ++k) {
      moved[slot_of_[p] * block() + k] = Basis(slot, k % components_).dot(value);
    }
  }
  inverse_.Multiply(moved, tractions);
}

void MovingContacts::Respond(std::span<const double> prescribed,
                             std::span<double> answer) noexcept {
  SolveTractions(prescribed, moved_.data(), tractions_.data());
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
  std::vector<double> moved(moved_.size(), 0.0);
  std::vector<double> tractions(moved_.size(), 0.0);
  SolveTractions(prescribed, moved.data(), tractions.data());
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
