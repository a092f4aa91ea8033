// `bem3d`: a solid elastic body by boundary elements on its triangulated surface, precomputed
// Green's functions and the capacitance of its contacts (paper A, 3.3-3.4, for solids). Linear:
// small strains and rotations. Once precomputed, a contact costs microseconds whatever the mesh.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/mechanics/bem3d/surface_greens.h"
#include "slave/mechanics/capacitance/compliance_solver.h"
#include "slave/mechanics/capacitance/contact_set.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"

namespace palpate {

// On the surface, triangle by triangle. Frame O.
struct SurfaceState {
  std::vector<Eigen::Vector3d> displacement;  // of the centroids [m]
  std::vector<Eigen::Vector3d> traction;      // on the body [Pa]
};

// See ComplianceSolver and SurfaceTrianglePlaces. A body that is free to move takes loads only;
// they must balance to 1e-6, and the solution has no mean displacement nor turn of the surface,
// weighted by area. A place is found by a walk over all triangles if `element` is -1 and the
// contact changed.
class Bem3dModel final : public DeformationModel {
 public:
  struct Options {
    ContactLaw contact = ContactLaw::kBonded;
    double range = 0.1;  // largest |displacement| / larger side before `extrapolated` [-]
    std::filesystem::path cache{};                     // see SurfaceGreens
    std::size_t memory_limit = std::size_t{8} << 30U;  // of the precompute [bytes]
  };

  // `held`: per triangle and component, kept at zero. Throws std::invalid_argument: see
  // SurfaceGreens; modulus or range not positive. Interrupted.
  Bem3dModel(const SurfaceMesh& mesh, HeldNodes held, double young_modulus, double poisson_ratio,
             const Options& options, Progress* progress = nullptr);

  [[nodiscard]] std::string_view failure() const override {
    return failure_.empty() ? solver_.failure() : failure_;
  }

  // Zero if it failed or nothing was solved. O(N S).
  [[nodiscard]] SurfaceState Surface(const Solution& solution);

  [[nodiscard]] const SurfaceGreens& greens() const { return greens_; }

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  // The corners' displacements that the boundary integrals used (CornerFit): exact for linear
  // fields, otherwise to O(h^2).
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  void Describe(const Options& options);
  [[nodiscard]] double MeasureUpdate();
  [[nodiscard]] std::string_view Refuse(std::span<const Contact> contacts) const noexcept;
  [[nodiscard]] bool Balanced();
  void AtCentroids(std::vector<Eigen::Vector3d>* u_O);

  double young_modulus_;  // [Pa]
  SurfaceGreens greens_;
  SurfaceTrianglePlaces places_;
  ComplianceSolver solver_;
  double force_unit_ = 0;  // E times the length unit squared [N]
  std::vector<PlaceForce> forces_;
  std::vector<Eigen::Vector3d> centroids_;  // their displacements [m]
};

}  // namespace palpate
