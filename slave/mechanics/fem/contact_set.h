// Contacts as the nodes of a body that they load or move.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/footprint/contact_footprint.h"

namespace palpate::fem {

// Remembers the last set, so that contacts that stay where they are cost nothing to find.
class ContactSet {
 public:
  // Keeps a reference to the body; copies the mesh's surface.
  ContactSet(const SolidMesh& mesh, const FemBody& body);

  enum class Change { kNone, kLoads, kHolds };
  // Finds where the contacts are; `constraints` get those that prescribe displacements if these
  // have changed. Returns what did, or why it cannot be.
  struct Result {
    Change change = Change::kNone;
    const char* refusal = nullptr;
    int contact = -1;  // the one refused
  };
  Result Update(std::span<const Contact> contacts, Constraints& constraints);
  // The last set is not to be trusted.
  void Forget() { ready_ = false; }

  // Adds loads to f and moves prescribed nodes; values in SI, f and u in units of the body. False:
  // a contact moves a fixed node.
  bool Apply(std::span<const Contact> contacts, double length_unit, double force_unit,
             Constraints& constraints, NodeVector& f) const noexcept;
  // The mean displacement of contact k weighted as its load is, or of the nodes it moves.
  [[nodiscard]] Eigen::Vector3d Mean(std::size_t k, const NodeVector& u) const noexcept;
  // Its number among those that prescribe displacements; -1: a load.
  [[nodiscard]] int hold(std::size_t k) const { return places_[k].hold; }
  // The nodes that it loads or moves, by their numbers in the body.
  [[nodiscard]] std::span<const PlaceWeight> nodes(std::size_t k) const { return places_[k].nodes; }
  // Of a disc, from its centre to nodes(k) (ContactFootprint); else empty.
  [[nodiscard]] std::span<const Eigen::Vector3d> arms(std::size_t k) const {
    return places_[k].arms;
  }
  // Whether the mesh is too coarse for its patch (mesh_resolution.h).
  [[nodiscard]] bool coarse(std::size_t k) const { return places_[k].coarse; }
  // See kOnSupport (mesh_resolution.h).
  [[nodiscard]] bool on_support(std::size_t k) const { return places_[k].on_support; }

 private:
  struct Key {
    Contact::Kind kind;
    Eigen::Vector3d p_O;
    double width;
    bool operator==(const Key& other) const = default;
  };
  struct Place {
    std::vector<PlaceWeight> nodes;     // of the body
    std::vector<Eigen::Vector3d> arms;  // see arms()
    bool point = false;                 // the weighted mean is fixed, not each node
    int hold = -1;
    bool coarse = false;  // IsPatchCoarse
    bool on_support = false;
  };

  const char* Find(const Contact& contact, Place& place);
  bool Hold(const Place& place, Constraints& constraints);

  const FemBody& body_;
  SurfaceFootprints footprints_;
  ContactFootprint footprint_;  // room
  std::vector<int> held_;       // room
  std::vector<Key> keys_;
  bool ready_ = false;
  std::vector<Place> places_;
};

}  // namespace palpate::fem
