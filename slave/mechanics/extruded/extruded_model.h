// `extruded`: an outline with its thickness under a rigid flat tool that reaches through a part of
// it, glued. Linear. Contacts and displacements are those of a planar model: the outline is the
// front edge of the body, which a camera sees.
//
// Each tool position needs a finite element solution (pressed_prism.h) at its first query. Later
// queries there use a 2 x 2 stiffness.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"
#include "slave/mesh/outline.h"

namespace palpate {

// Accepts one contact at a time, moved or loaded; its width is that of the tool. kFailed: more than
// one contact, or a tool on a fixed part. Preparing a place takes tenths of a second and allocates.
class ExtrudedModel final : public DeformationModel {
 public:
  struct Params {
    double young_modulus = 0;  // E [Pa]
    double poisson_ratio = 0;  // nu [-], < 0.5
    double thickness = 0;      // [m]
    double front = 0;          // of the tool, behind the front face [m]
    double depth = 0;          // of the tool, from there on [m]
    double range = 0.1;        // largest |displacement| / larger side before `extrapolated` [-]
  };

  // `held`: components x, y of each element. Throws std::invalid_argument: a parameter beyond its
  // range, nothing is held.
  ExtrudedModel(BoundaryMesh mesh, std::vector<std::array<bool, 2>> held, const Params& params);
  ~ExtrudedModel() override;

  void Prefetch(std::span<const Contact> contacts) override;

 private:
  struct Place;

  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  [[nodiscard]] PlanarCover MakeCover() const override { return CoverOf(mesh_, kCoverPlaces); }
  void ComputeInside(const std::vector<Eigen::Vector2d>& places,
                     std::vector<Eigen::Vector3d>* u_O) override;
  // The displacements at places of the outline and then inside, from `first` on.
  void AppendFront(std::size_t first, std::size_t count, std::vector<Eigen::Vector3d>* u_O) const;
  const Place* Find(const Contact& contact);
  std::unique_ptr<Place> Prepare(int element, const Eigen::Vector2d& p_O, double width);

  BoundaryMesh mesh_;
  std::vector<std::array<bool, 2>> held_;
  Params params_;
  double larger_side_ = 0;  // [m]
  std::vector<std::unique_ptr<Place>> places_;
  // Position of the last query.
  const Place* shown_ = nullptr;
  Eigen::Vector2d moved_O_{0, 0};  // the tool [m]
};

}  // namespace palpate
