// What contacts do to the unknowns of a solid: values they prescribe, loads they spread, weighted
// sums of displacements they prescribe (contracts, `solve`).
#pragma once

#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/solid/element_mesh.h"
#include "slave/mechanics/footprint/contact_footprint.h"

namespace palpate {

// Where one contact acts. Exactly one of the first two ways to move is used by a displacement.
struct ContactPlace {
  std::vector<int> moved;                       // nodes that are moved alike
  std::vector<std::pair<int, double>> weights;  // nodes and shares, sum 1, of a load; of a moved
                                                // point where no node is `moved`
  bool coarse = false;                          // IsPatchCoarse
  // Of a disc, from its centre to each node of `moved`, or of `weights` of a load
  // (ContactFootprint) [length units]; else empty.
  std::vector<Eigen::Vector3d> arms;
};

class SolidContacts {
 public:
  // Keeps references. `used`: nodes that belong to an element.
  SolidContacts(const ElementMesh& mesh, const std::vector<bool>& used, double length_unit);

  // Finds the positions; false: failure() is the reason. No work for the same contacts as before,
  // whatever their values. O(N) per new contact.
  bool Prepare(std::span<const Contact> contacts);
  // Whether the last Prepare met new places.
  [[nodiscard]] bool changed() const { return changed_; }
  [[nodiscard]] std::span<const ContactPlace> places() const { return places_; }
  [[nodiscard]] std::string_view failure() const { return failure_; }
  // Prepares again next time.
  void Forget() { known_ = false; }

 private:
  bool Refuse(std::string_view why) {
    failure_ = why;
    return false;
  }
  bool Find(const Contact& contact, ContactPlace* place);
  bool FindPatch(const Contact& here, ContactPlace* place);
  void SetArms(const Contact& here, const DiscShare& disc, ContactPlace* place) const;
  void Touch(const SurfacePlace& at, ContactPlace* place) const;
  void PointWeights(int triangle, const Eigen::Vector3d& weights, ContactPlace* place) const;
  bool Overlap(std::span<const Contact> contacts);

  const ElementMesh& mesh_;
  const std::vector<bool>& used_;
  double unit_;
  SurfaceFootprints footprints_;
  ContactFootprint footprint_;  // room
  bool known_ = false, changed_ = false;
  std::vector<Contact> contacts_;
  std::vector<ContactPlace> places_;
  std::vector<int> owner_;  // per node, of those moved: the contact; -1: none
  std::string_view failure_;
};

}  // namespace palpate
