// Boundary elements of a plane body that a contact touches (rules: slave/solve/README.md).
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem/greens_functions.h"
#include "slave/mechanics/capacitance/contact_set.h"

namespace palpate {

// Places are the nodes of one element or, for a contact with a width, of a patch of elements. Its
// nodes have equal displacements or loads in proportion to their lengths. Stores a reference to the
// Green's functions.
class ElementPlaces final : public ContactPlaces {
 public:
  // Nodes of a patch below which the moment of its force is unknown.
  static constexpr std::size_t kMinForMoment = 2;

  // `larger_side`: of the body [m].
  ElementPlaces(const GreensFunctions& greens, double larger_side);
  std::string_view Find(const Contact& contact, ContactFootprint* footprint) override;

 private:
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
