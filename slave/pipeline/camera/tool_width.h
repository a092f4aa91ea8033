// Corrects the force for whole boundary elements in place of a flat tool and of a fixed arc.
//
// A patch holds each element whose midpoint the tool covers: it is as wide as these are, not as the
// tool, and a little less, since the elements at its ends carry less than the traction there, which
// is singular. It is taken for L - a h wide, h the length of an element; a was fitted to quadratic
// finite elements graded towards a bonded tool's ends, on blocks, wedges and discs with 1.5 to 10
// elements under the tool. Of a plane body the compliance goes with the logarithm of the width
// (Johnson 1985, 2.5); two patches give the rate. The support carries the same force over its own
// length, so a disc's held arc, which is of whole elements too, counts as fast with the other sign:
// 0.86 times so over 59 discs.
//
// What is left: of the end's law, an expansion in h / w, the next order; shares of what was put
// right; and the elements elsewhere. Measured on 141 blocks, wedges and discs of constant elements
// with h < 0.8 w, against meshes graded to 1e-4: error by sigma 0.99 rms, 70 and 96 % within one
// and two. Longer elements err by less than their sigma, 0.8 rms.
#pragma once

#include "slave/contact/boundary_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"

namespace palpate {

class ToolWidth {
 public:
  // Keeps a reference to the mesh.
  ToolWidth(const BoundaryMesh& mesh, const Scene& scene);

  struct Share {
    double factor = 1;  // by which the patch's force and stiffness are to be multiplied
    double sigma = 0;   // remaining error, as share of the force [-]
  };
  // Queries the model for two contacts at `place` unless it is the last one. No allocation.
  Share At(const BoundaryPlace& place, DeformationModel* model) noexcept;

 private:
  [[nodiscard]] double LengthOf(const BoundaryPlace& place, double width) const noexcept;
  [[nodiscard]] double Compliance(const BoundaryPlace& place, double width,
                                  DeformationModel* model) const noexcept;
  [[nodiscard]] Share Find(const BoundaryPlace& place, DeformationModel* model) const noexcept;

  const BoundaryMesh* mesh_;
  double width_;         // width of the tool [m]; 0: no correction
  double ends_;          // a above
  double support_;       // ln of the held length by that of the scene's arcs; 0: no arcs
  BoundaryPlace place_;  // element of the last result; -1: none
  Share last_;
};

}  // namespace palpate
