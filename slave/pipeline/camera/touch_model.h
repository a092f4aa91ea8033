// Response of the outline to a flat or round tool, for one camera.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/contact/boundary_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/factory/tool_domain.h"
#include "slave/mesh/outline.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/camera/tool_width.h"
#include "slave/scene/scene.h"

namespace palpate {

// The part that SetModel replaces as a whole. One thread at a time; frame O.
struct TouchModel final : PreparedModel {
  // `found_outline`: in the image, for `contour: from-image`, else null. Throws the exceptions of
  // MakeModel.
  TouchModel(const Scene& scene, std::shared_ptr<const Outline> found_outline, Progress* progress);
  // Uses a mesh whose model may exist already.
  TouchModel(const Scene& scene, BoundaryMesh outline, std::unique_ptr<DeformationModel> model,
             Progress* progress = nullptr);

  [[nodiscard]] const ModelInfo& info() const override { return deformation->info(); }

  // Displacement of the tool since its first contact: along the normal that of its centre, across
  // it that of its point that touched first. And, of a round tool that has turned, the distance
  // across the normal from the centre to that point [m].
  struct ToolMotion {
    Eigen::Vector3d displacement_O{0, 0, 0}, rolled_O{0, 0, 0};
  };
  // Computes the contact of the tool at `place`.
  [[nodiscard]] ContactResponse Respond(const BoundaryPlace& place,
                                        const ToolMotion& motion) noexcept {
    return Solve(place, motion, &asked_);
  }
  // Solves for the present tool: `pressed` becomes its solution.
  [[nodiscard]] ContactResponse Press(const BoundaryPlace& place,
                                      const ToolMotion& motion) noexcept {
    return Solve(place, motion, &pressed);
  }
  // Computes the displacements of the outline's vertices for a motion of the tool [m]. False:
  // unknown. Across the normal a round tool is treated as a flat one.
  bool FieldOf(const BoundaryPlace& place, const Eigen::Vector3d& displacement_O,
               std::vector<Eigen::Vector3d>* field) noexcept;
  [[nodiscard]] ToolWidth::Share WidthAt(const BoundaryPlace& place) noexcept;
  // Returns the secant stiffness divided by the tangent stiffness [-]: below 1 where the contact
  // was smaller at smaller depths, under a round tool or on a curved outline.
  [[nodiscard]] double SecantPart(const ContactResponse& response,
                                  const BoundaryPlace& place) const noexcept;

  // Returns the relative standard deviation of a force caused by whole elements in the contact of a
  // round tool; 0 for a flat one [-].
  [[nodiscard]] double RoundSigma(const ContactResponse& response) const noexcept;

  // True for `extruded`, whose places take tenths of a second each: a distant tip uses the last
  // place, a near one that of a raster on the outline.
  [[nodiscard]] bool prepares_places() const { return prepares_places_; }

  // Half the tool's width [m].
  [[nodiscard]] double reach() const { return tool_width_ / 2; }
  // Radius of the tool's end [m]; 0: flat.
  [[nodiscard]] double radius() const { return tool_radius_; }
  [[nodiscard]] bool is_round() const { return tool_radius_ > 0; }

  std::shared_ptr<const Outline> outline;  // outline of the mesh; null: that of the scene
  ContactLaw law = ContactLaw::kBonded;
  BoundaryMesh mesh;
  std::unique_ptr<DeformationModel> deformation;
  ToolDomain domain;  // of the scene's tool on this mesh
  Solution pressed;   // of the last Press
  std::unique_ptr<BoundaryContact> contact;
  std::unique_ptr<BoundaryContact> probe;  // finds the place below any tool
  std::vector<std::uint32_t> held;         // vertices of the outline
  // Stiffness along the normal at the place nearest to the tool's home [N/m]; 0: no place is
  // prepared.
  double stiffness_at_home = 0;

 private:
  [[nodiscard]] ContactResponse Solve(const BoundaryPlace& place, const ToolMotion& motion,
                                      Solution* solution) noexcept;
  [[nodiscard]] ContactResponse Answer(const BoundaryPlace& place, const ToolMotion& motion,
                                       Solution* solution) noexcept;
  [[nodiscard]] ContactResponse SolveFlat(const BoundaryPlace& place,
                                          const Eigen::Vector3d& displacement_O,
                                          Solution* solution) noexcept;

  void PrepareUnder(const Eigen::Vector3d& p_O_tip) noexcept;
  [[nodiscard]] Contact ContactAt(const BoundaryPlace& place) noexcept;

  Solution asked_;  // of other queries
  bool prepares_places_ = false;
  Contact prepared_;                // last place that was near
  double tool_width_;               // [m]
  double tool_radius_ = 0;          // [m]; 0: a flat tool
  std::optional<ToolWidth> width_;  // of a flat tool
};

// Projection of a vector into the image plane.
inline Eigen::Vector3d Planar(const Eigen::Vector2d& v) {
  return {v.x(), v.y(), 0};
}

// A passive contact has a symmetric stiffness; collocation leaves a small skew part, which would
// create energy at the operator. Frame S [N/m]; zero if the model failed.
[[nodiscard]] Eigen::Matrix3d StiffnessInSlave(const ContactResponse& response,
                                               const Eigen::Isometry3d& X_SO) noexcept;

}  // namespace palpate
