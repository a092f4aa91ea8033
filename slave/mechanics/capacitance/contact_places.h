// Which places of a compliance a contact touches, and with what share: the conventions of a model's
// boundary (nodes or triangles), kept out of the solver.
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"

namespace palpate {

struct PlaceWeight {
  int place = -1;     // of the Compliance
  double weight = 0;  // share [-]
};

// What one contact touches.
//
// A load's force is shared out by the weights, which sum to one, and the displacement reported is
// the mean by the same weights (the work is then force times displacement). So is a contact that
// acts as a `point`: one unknown force, the weighted mean is prescribed. Otherwise every place is
// moved alike with an unknown force of its own, and the weights do not count.
struct ContactFootprint {
  std::vector<PlaceWeight> places;
  bool point = true;                  // at most kMostPointPlaces places
  Eigen::Vector3d normal_O{0, 0, 0};  // outward, unit; the direction of frictionless contacts
  bool coarse = false;                // IsPatchCoarse (mesh_resolution.h)
};
constexpr int kMostPointPlaces = 3;

class ContactPlaces {
 public:
  virtual ~ContactPlaces() = default;
  ContactPlaces() = default;
  ContactPlaces(const ContactPlaces&) = delete;
  ContactPlaces& operator=(const ContactPlaces&) = delete;

  // Finds what `contact` touches; its kind, p_O, element and width count, its value does not.
  // Empty: found; otherwise why not, one clause that lives on. Allocates nothing where `footprint`
  // has room already. Called only for contacts that changed; the contact is finite.
  virtual std::string_view Find(const Contact& contact, ContactFootprint* footprint) = 0;
};

}  // namespace palpate
