// Determines which nodes of a meshed volume each contact loads or moves (rules:
// slave/solve/README.md), for all models that solve for every node.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/footprint/volume_footprints.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate {

struct ContactPlace {
  // Nodes of the mesh, including mid-edge nodes, with their shares of a load (sum 1).
  std::vector<PlaceWeight> nodes;
  // True: a displacement is that of the weighted mean of the nodes; false: it is that of each node.
  bool is_point = false;
  // Of a rigid tool whose nodes touch one by one: its axis and, per node, how it is touched. Else
  // empty.
  Eigen::Vector3d axis_O{0, 0, 0};
  std::vector<ToolHold> holds;
  double depth = 0;                   // of a round tool, see ContactFootprint [m]
  std::size_t fewest = 0;             // see ContactFootprint
  std::vector<Eigen::Vector3d> arms;  // of a disc, see ContactFootprint [m]; else empty
  double patch_error = 0;             // PatchError (mesh_resolution.h)
  bool on_support = false;            // see kOnSupport (mesh_resolution.h)
};

// Stores the last set, so that unchanged contacts are not searched again.
class VolumeContacts {
 public:
  // `finds_tools`: the nodes of a rigid tool are those that it may touch one by one, else those of
  // a disc. `held`: per node of `mesh`. A force unit is E times a length unit squared [N].
  VolumeContacts(const SolidMesh& mesh, int nodes_per_element, const HeldNodes& held,
                 double length_unit, double force_unit, bool finds_tools = false);

  // Difference from the last set: none, only loads, or prescribed displacements.
  enum class Change { kNone, kLoads, kHolds };
  // Finds the places. False: failure() is the reason: a number that is not finite or beyond a
  // million units, no surface or element there, a contact that rests by half or more on nodes that
  // another one moves, or moves such a node itself. O(surface) per new contact without `element`.
  bool Prepare(std::span<const Contact> contacts);
  [[nodiscard]] Change change() const { return change_; }
  // Number of nodes, including mid-edge nodes.
  [[nodiscard]] std::size_t node_count() const { return mesh_.nodes.size(); }
  [[nodiscard]] std::span<const ContactPlace> places() const { return places_; }
  // Returns whether the mesh is too coarse for the width of a contact with this response.
  [[nodiscard]] bool IsCoarse(std::size_t contact, const ContactResponse& response) const {
    const double young_modulus = force_unit_ / (length_unit_ * length_unit_);
    return IsContactCoarse(places_[contact].patch_error, young_modulus * contacts_[contact].width,
                           response.force_O, response.displacement_O);
  }
  // The same for the nodes that a tool touches.
  [[nodiscard]] bool TouchesFew(std::size_t contact, int touching,
                                const ContactResponse& response) const {
    const double young_modulus = force_unit_ / (length_unit_ * length_unit_);
    const Contact& at = contacts_[contact];
    const double error = FewTouchedError(touching, places_[contact].fewest, at.radius > 0);
    return IsContactCoarse(error, young_modulus * at.width, response.force_O,
                           response.displacement_O);
  }
  [[nodiscard]] std::string_view failure() const { return failure_; }
  // Forgets the last set.
  void Forget() { ready_ = false; }

 private:
  bool Refuse(std::size_t contact, std::string_view why);
  [[nodiscard]] bool IsKnown(std::size_t contact, const Contact& now) const;
  [[nodiscard]] std::string_view FindSizes(const Contact& contact) const;
  std::string_view Find(const Contact& contact, ContactPlace* place);
  [[nodiscard]] int Overlapping(std::span<const Contact> contacts);

  TetMesh mesh_;    // [m]
  HeldNodes held_;  // including mid-edge nodes; nodes without element count as fixed
  std::vector<bool> used_;
  double length_unit_, force_unit_;
  bool finds_tools_;
  VolumeFootprints footprints_;
  ContactFootprint footprint_;  // scratch
  std::vector<Contact> contacts_;
  std::vector<ContactPlace> places_;
  std::vector<int> owner_;  // scratch, per node: the contact that moves it; -1: none
  Change change_ = Change::kNone;
  bool ready_ = false;
  std::string failure_;
};

}  // namespace palpate
