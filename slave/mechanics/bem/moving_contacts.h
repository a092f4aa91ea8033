// Contacts that come, go and move one at a time, answered by an inverse of the capacitance matrix
// that is updated rather than made again.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/geometry/index.h"
#include "slave/mechanics/bem/capacitance_solver.h"
#include "slave/mechanics/bem/greens_functions.h"
#include "slave/mechanics/linear/updated_inverse.h"

namespace palpate {

// Nondimensional, as CapacitanceSolver is, and what it does: displacements prescribed on single
// elements of a body that the scene fixes. Everything else is CapacitanceSolver's. Not thread-safe.
// Memory only grows.
class MovingContacts {
 public:
  // Below so many contacts a factorisation costs no more than an update.
  static constexpr int kFewest = 12;

  explicit MovingContacts(const GreensFunctions& greens);

  // Prepares a set of patches of one element each. What is new since the last set is appended, what
  // is gone removed, O(m^2) each; or the matrix is factorised again, O(m^3), where that is faster
  // or the updates have drifted. False: not what this class is for, or no unique answer; no set
  // then.
  bool Prepare(std::span<const ContactPatch> patches);

  // The next set is prepared from nothing.
  void Forget();

  // Per patch x, y of the displacement; of the total force. O(m^2).
  void Respond(std::span<const double> prescribed, std::span<double> answer) noexcept;
  // The first one after a factorisation costs as much as that.
  [[nodiscard]] Eigen::Matrix2d Derivative(int patch) noexcept;
  void Boundary(std::span<const double> prescribed, std::vector<Eigen::Vector2d>* displacement,
                std::vector<Eigen::Vector2d>* traction) const;

  // Since construction: how many contacts were put in or taken out, how many sets were factorised.
  struct Counts {
    std::int64_t updates = 0, factorisations = 0;
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  struct Slot {  // one block of the inverse
    int first_node = 0;
    Eigen::Vector2d direction{0, 0};  // zero: bonded
    int set = 0;                      // the last one it was in
    bool fresh = true;                // not in the inverse yet
  };

  [[nodiscard]] bool Suits(std::span<const ContactPatch> patches) const noexcept;
  bool Match(std::span<const ContactPatch> patches, int* missing);
  bool Update(std::span<const ContactPatch> patches);
  bool Rebuild(std::span<const ContactPatch> patches, bool few_changed);
  bool MakeRoom(std::span<const ContactPatch> patches);
  bool Assign(const ContactPatch& patch, std::size_t patch_index, int slot);
  void Erase(int slot);
  void FillBlock(const Slot& to, int row, const Slot& from, int column);
  void FillBlocks(int slot, int others);
  void Fetch(const ContactPatch& patch, std::span<const ContactPatch> others) const;
  [[nodiscard]] int block() const { return components_ * nodes_per_patch_; }
  [[nodiscard]] int& SlotAt(const Slot& slot) {
    return slot_at_[Index(greens_.node(slot.first_node).element)];
  }
  [[nodiscard]] Eigen::Vector2d Basis(const Slot& slot, int k) const noexcept {
    return components_ == 1 ? slot.direction : Eigen::Vector2d::Unit(k);
  }
  void SolveTractions(std::span<const double> prescribed, double* moved,
                      double* tractions) const noexcept;

  const GreensFunctions& greens_;
  int nodes_per_patch_ = 1;
  int components_ = 2;             // unknown at each node: 1 without friction
  std::size_t free_elements_ = 0;  // elements that are not fixed
  UpdatedInverse inverse_{false};
  std::vector<Slot> slots_;
  std::vector<int> slot_at_;        // per element; -1: none
  std::vector<int> slot_of_;        // per patch; -1: still to be added
  AlignedArray moved_, tractions_;  // zero beyond the inverse's order
  int room_ = 0;                    // of both
  int set_ = 0;
  Counts counts_;
};

}  // namespace palpate
