// Corrects the force because whole boundary elements represent a flat tool and a fixed arc.
//
// A patch consists of the elements whose midpoints the tool covers. Its effective width is that of
// these elements, reduced because the elements at the ends carry less than the singular traction
// there. It is L - a h, with the length h of an element; a was fitted to quadratic finite elements
// graded towards a bonded tool's ends, on blocks, wedges and discs with 1.5 to 10 elements under
// the tool. The compliance of a plane body varies with the logarithm of the width (Johnson 1985,
// 2.5); the rate follows from two patches. The support carries the same force, so a disc's fixed
// arc, which also consists of whole elements, has the same effect with opposite sign: 0.86 times as
// large over 59 discs.
//
// The remaining error is the next order of the expansion in h / w, a share of the correction, and
// the error of the other elements. Measured on 141 blocks, wedges and discs of constant elements
// with h < 0.8 w, against meshes graded to 1e-4: the error divided by sigma has an rms of 0.99; 70
// and 96 % are within one and two sigma. Longer elements have smaller errors than their sigma, 0.8
// rms.
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
    double factor = 1;  // factor on the patch's force and stiffness
    double sigma = 0;   // remaining error, relative to the force [-]
    // Corrects the answer to one contact.
    void Correct(ContactResponse* response) const noexcept;
  };
  // Queries the model for two contacts at `place` unless it is the last one. No allocation.
  Share At(const BoundaryPlace& place, DeformationModel* model) noexcept;

 private:
  [[nodiscard]] double LengthOf(const BoundaryPlace& place, double width) const noexcept;
  [[nodiscard]] double Compliance(const BoundaryPlace& place, double width,
                                  DeformationModel* model) const noexcept;
  [[nodiscard]] Share Find(const BoundaryPlace& place, DeformationModel* model) const noexcept;

  const BoundaryMesh* mesh_;
  double width_;  // width of the tool [m]; 0: no correction
  double ends_;   // a above
  // Ln of the ratio of the supported length to that of the scene's arcs; 0: no arcs.
  double support_;
  BoundaryPlace place_;  // element of the last result; -1: none
  Share last_;
};

}  // namespace palpate
