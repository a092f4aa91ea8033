// Contacts on a body with known Green's functions: the capacitance matrix algorithm.
//
//   C = -I_S^T E I_S,   V_S = C^-1 I_S^T Y_0,   Y_0 = [E (I - I_S I_S^T) - I_S I_S^T] Ybar
//
// Source: James and Pai (2003); paper A, eqs. (5)-(7), with Y_0 general: loads act beside contacts.
// Everything here is nondimensional: lengths by the mesh's unit, tractions by E, forces per
// thickness by E times the unit.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/geometry/index.h"
#include "slave/mechanics/bem/greens_functions.h"
#include "slave/mechanics/linear/dense_factor.h"

namespace palpate {

// Nodes of the boundary elements that move or are loaded together.
struct ContactPatch {
  enum class Law : std::uint8_t {
    kBonded,        // both components of the displacement are prescribed
    kFrictionless,  // the displacement along `direction` is, and the traction across it is zero
    kLoad           // a uniform traction is prescribed
  };
  Law law = Law::kBonded;
  std::span<const int> nodes;
  Eigen::Vector2d direction{0, 0};  // unit vector, kFrictionless only
};

// Not thread-safe. Memory only grows: once a set of contacts of some size has been prepared,
// smaller ones allocate nothing. Keeps a reference to the Green's functions.
class CapacitanceSolver {
 public:
  explicit CapacitanceSolver(const GreensFunctions& greens);

  // Prepares a set of patches; `nodes` are copied. O(m^3 + m^2 M), m prescribed components, M
  // patches. Loads add up where they overlap. False: a node of a contact in another patch, or a
  // system without a unique solution (a body that is not fixed and whose contacts leave a rigid
  // motion free; displacements on the whole boundary near nu = 0.5 in plane strain).
  bool Prepare(std::span<const ContactPatch> patches);

  // `prescribed`: per patch x, y of the displacement or, for kLoad, of the total force. `answer`:
  // the total force or, for kLoad, the displacement averaged over the patch. O(M^2). False: a
  // nonzero value along a component that the reference problem holds, loads out of balance on a
  // body without fixed nodes.
  bool Respond(std::span<const double> prescribed, std::span<double> answer) const noexcept;

  // d answer / d prescribed of one patch, all other patches as they are prescribed.
  [[nodiscard]] Eigen::Matrix2d Derivative(int patch) const noexcept;
  // The reference problem holds this component somewhere on the patch.
  [[nodiscard]] bool blocked(int patch, int component) const noexcept {
    return patches_[static_cast<std::size_t>(patch)].blocked[static_cast<std::size_t>(component)];
  }

  // Displacements and tractions of every node under `prescribed`. O(N m).
  void Boundary(std::span<const double> prescribed, std::vector<Eigen::Vector2d>* displacement,
                std::vector<Eigen::Vector2d>* traction) const;

  // visit(node, force) for the nodes of one patch under `prescribed`, without what supports carry.
  template <class Visit>
  void ForEachForce(std::span<const double> prescribed, int patch, const Visit& visit) const {
    const Patch& of = patches_[Index(patch)];
    if (of.law == ContactPatch::Law::kLoad) {
      const Eigen::Vector2d force(prescribed[2 * Index(patch)], prescribed[2 * Index(patch) + 1]);
      for (const int j : NodesOf(of)) visit(j, greens_.lengths()[Index(j)] / of.length * force);
      return;
    }
    for (const auto& u : unknowns_) {
      if (u.patch == patch)
        visit(u.node, greens_.lengths()[Index(u.node)] * Traction(u, prescribed));
    }
  }

 private:
  struct Patch {
    ContactPatch::Law law = ContactPatch::Law::kBonded;
    int begin = 0, end = 0;  // in nodes_
    double length = 0;       // of its nodes together
    std::array<bool, 2> blocked{};
  };
  // The unknown traction components of one node: basis columns 0 to count.
  struct Unknowns {
    int node = 0;
    int patch = -1;  // -1: free motions
    int row = 0;
    int count = 0;
    Eigen::Matrix2d basis = Eigen::Matrix2d::Identity();
  };

  [[nodiscard]] Eigen::Vector2d Traction(const Unknowns& u,
                                         std::span<const double> prescribed) const noexcept;
  bool CollectPatches(std::span<const ContactPatch> patches);
  void CollectUnknowns(const ContactPatch& patch, int index);
  bool CollectFreeMotions();
  [[nodiscard]] bool LosesPressure() const noexcept;
  void FillCapacitance();
  void Fetch(const Unknowns& from) const noexcept;
  void FillPrescribed();
  void FillMap();
  [[nodiscard]] Eigen::Matrix2d Block(int i, int j) const noexcept {
    return Eigen::Map<const Eigen::Matrix2d>(greens_.block(i, j));
  }
  [[nodiscard]] Eigen::Matrix2d ByLoad(int node, const Patch& load) const noexcept;
  [[nodiscard]] Eigen::Matrix2d Observed(const Patch& patch, int by_node) const noexcept;
  // Loads observe their displacement, contacts the fixture's reaction where they meet one.
  [[nodiscard]] bool Observes(const Patch& patch) const noexcept {
    return patch.law == ContactPatch::Law::kLoad || patch.blocked[0] || patch.blocked[1];
  }
  [[nodiscard]] bool Balanced(std::span<const double> prescribed) const noexcept;
  [[nodiscard]] std::span<const int> NodesOf(const Patch& patch) const noexcept {
    return std::span(nodes_).subspan(Index(patch.begin), Index(patch.end - patch.begin));
  }

  const GreensFunctions& greens_;
  std::vector<Patch> patches_;
  std::vector<int> nodes_;
  std::vector<int> taken_by_;  // per node: preparation that used it last, negative for a load
  int preparation_ = 0;
  std::vector<Unknowns> unknowns_;
  int order_ = 0;                  // unknown components in all
  std::vector<double> augmented_;  // [-C | prescribed], then [. | tractions by prescribed value]
  RowMajor system_;
  int first_value_ = 0;  // the column of system_ where the prescribed values begin
  std::vector<double> scratch_;
  std::vector<double> map_;  // 2M x 2M, row-major: answer by prescribed value
};

}  // namespace palpate
