// How the outline that one camera sees answers the tool, flat or round.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"
#include "slave/contact/boundary_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/indenter/round_indenter.h"
#include "slave/pipeline/camera/tool_width.h"
#include "slave/pipeline/sensing_pipeline.h"
#include "slave/scene/scene.h"

namespace palpate {

// The part that SetModel replaces as a whole. One thread at a time; frame O.
struct TouchModel final : PreparedModel {
  // `seen`: the outline found in the picture, for `contour: from-image`. Throws like MakeModel.
  TouchModel(const Scene& scene, const std::optional<Outline>& seen, Progress* progress);

  [[nodiscard]] const ModelInfo& info() const override { return deformation->info(); }

  // The tool's patch, or a round tool's apex, at `place` moved by `displacement_O` [m].
  [[nodiscard]] ContactResponse Respond(const BoundaryPlace& place,
                                        const Eigen::Vector3d& displacement_O) noexcept;
  // Displacements of the outline's vertices for the same [m]. False: not known. Across the normal a
  // round tool moves as a flat one does.
  bool FieldOf(const BoundaryPlace& place, const Eigen::Vector3d& displacement_O,
               std::vector<Eigen::Vector3d>* field) noexcept;
  [[nodiscard]] ToolWidth::Share WidthAt(const BoundaryPlace& place) noexcept;
  // That share of the stiffness which at this depth gives this force, of a round tool whose contact
  // was smaller before; 1 of a flat one [-].
  [[nodiscard]] double SecantPart(const ContactResponse& response,
                                  const BoundaryPlace& place) const noexcept;

  ContactLaw law = ContactLaw::kBonded;
  BoundaryMesh mesh;
  std::unique_ptr<DeformationModel> deformation;
  std::unique_ptr<RoundIndenter> indenter;  // null: the tool is flat
  std::unique_ptr<BoundaryContact> contact;
  std::unique_ptr<BoundaryContact> probe;  // finds the nearest place of any point
  std::vector<std::uint32_t> held;         // vertices of the outline

 private:
  [[nodiscard]] ContactResponse RespondFlat(const BoundaryPlace& place,
                                            const Eigen::Vector3d& displacement_O) noexcept;

  double tool_width_;               // [m]
  std::optional<ToolWidth> width_;  // of a flat tool
};

// Of a vector in the plane of the picture.
inline Eigen::Vector3d Planar(const Eigen::Vector2d& v) {
  return {v.x(), v.y(), 0};
}

// A passive contact has a symmetric stiffness; collocation leaves a small skew part, which would
// create energy in the operator's hand. Frame S [N/m]; zero where the model failed.
[[nodiscard]] Eigen::Matrix3d StiffnessInSlave(const ContactResponse& response,
                                               const Eigen::Isometry3d& X_SO) noexcept;

}  // namespace palpate
