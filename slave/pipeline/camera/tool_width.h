// Corrects the force because whole boundary elements represent a fixed arc, and states the error of
// boundary elements under a flat tool, which they meet in part (element_places.h).
//
// The compliance of a plane body varies with the logarithm of the tool's width (Johnson 1985, 2.5);
// the rate follows from two widths. The support carries the same force, so a disc's fixed arc has
// the same effect with opposite sign: 0.86 times as large over 59 discs.
//
// The remaining error is the next order of the expansion in h / w, with the length h of an element,
// a share of the correction, and the error of the other elements.
#pragma once

#include "slave/contact/boundary_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"

namespace palpate {

class ToolWidth {
 public:
  // Stores a reference to the mesh.
  ToolWidth(const BoundaryMesh& mesh, const Scene& scene);

  struct Share {
    double factor = 1;  // factor on the force and stiffness
    double sigma = 0;   // remaining error, relative to the force [-]
    // Corrects the answer to one contact.
    void Correct(ContactResponse* response) const noexcept;
  };
  // Queries the model for two contacts at `place` unless it is the last one. No allocation.
  Share At(const BoundaryPlace& place, DeformationModel* model) noexcept;

 private:
  [[nodiscard]] double Compliance(const BoundaryPlace& place, double width,
                                  DeformationModel* model) const noexcept;
  [[nodiscard]] Share Find(const BoundaryPlace& place, DeformationModel* model) const noexcept;

  const BoundaryMesh* mesh_;
  double width_;  // width of the tool [m]; 0: no correction
  // Ln of the ratio of the supported length to that of the scene's arcs; 0: no arcs.
  double support_;
  BoundaryPlace place_;  // element of the last result; -1: none
  Share last_;
};

}  // namespace palpate
