// Boundary elements of a plane body that a contact touches (rules: slave/solve/README.md).
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem/greens_functions.h"
#include "slave/mechanics/capacitance/contact_set.h"

namespace palpate {

// Places are the nodes of one element or, for a load with a width, of a patch of elements, with
// loads in proportion to their lengths. A rigid tool may touch the nodes whose parts of the outline
// lie below it, at least in part. Stores a reference to the Green's functions.
//
// At the ends of a flat face the elements carry less load than the singular traction there: on a
// half-plane the face acts as if it were narrower by 0.26 to 0.34 constant elements, for one to
// eight of them. Therefore the face is taken to be wider by kEnds. The springs of rim_share.h, with
// 2.1 times the compliance 2 (1 - nu^2) / pi E of the logarithm, then keep its width within 0.05
// elements for any share above 0.1 of the outermost ones. [derived: a rigid face on a half-plane]
class ElementPlaces final : public ContactPlaces {
 public:
  // Nodes of a patch below which the moment of its force is unknown.
  static constexpr std::size_t kMinForMoment = 2;

  // `larger_side`: of the body [m].
  ElementPlaces(const GreensFunctions& greens, double larger_side);
  std::string_view Find(const Contact& contact, ContactFootprint* footprint) override;

 private:
  std::string_view FindTool(const Contact& contact, int element, ContactFootprint* footprint);
  // Adds the nodes of an element; false: the tool does not reach it.
  bool AddTouched(const Contact& contact, int element, ContactFootprint* footprint);
  // The outward normal, which turns steadily along a smooth outline.
  [[nodiscard]] Eigen::Vector2d AxisAt(int element, const Eigen::Vector2d& p_O) const;
  void FindElements(const Contact& contact, int element);
  [[nodiscard]] bool IsCoarse(double width) const;
  void SetArms(const Contact& contact, int element, ContactFootprint* footprint) const;
  [[nodiscard]] std::optional<double> OffCentre(const Eigen::Vector2d& p_O, int element) const;

  const GreensFunctions& greens_;
  double larger_side_;
  std::vector<Eigen::Vector2d> normals_;  // per element
  std::vector<int> elements_;             // of the last contact
};

}  // namespace palpate
