// `fem` with linear tetrahedra: linear or co-rotational, in equilibrium or in motion.
//
// The law is that of Mueller and Gross (2004), paper B [21], with the signed polar rotation
// (fem/tet_elements.h); equilibria by Newton's method (fem/static_equilibrium.h), motion by
// implicit Euler or Newmark's average acceleration (fem/time_stepper.h). Linear tetrahedra are
// first order accurate in stress and lock as nu approaches 0.5.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/contact_set.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/static_equilibrium.h"
#include "slave/mechanics/fem/time_stepper.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/scene/scene.h"

namespace palpate {

// Places and widths: contracts, `solve`. A contact that prescribes displacements holds the nodes of
// its patch, or the weighted point of the triangle there, and reports what that takes; on supports
// it must be zero and reports the reaction (in motion: its elastic part). In statics an object
// without fixed boundary takes balanced loads (to 1e-6) and moves without mean displacement and
// rotation.
//
// kExtrapolated: elements inside out (their number is in info().remark), nu > 0.49, the linear law
// out of range, a step of time that gained energy from nowhere, a mesh too coarse for a patch
// (mesh_resolution.h) or for a part that bends (mesh_resolution.h). kFailed: contacts that are not
// finite, overlap or lie nowhere, loads out of balance, no convergence, interruption; failure()
// says which.
class FemModel final : public DeformationModel {
 public:
  struct Params {
    Material material;   // E > 0 [Pa], -1 < nu < 0.5; a density wherever mass counts
    FemOptions options;  // tet4, law linear or co-rotational, pressure from the displacement
    // Largest |displacement| / larger side before `extrapolated` [-]; 0: 0.1 in the linear law,
    // none in the co-rotational one.
    double range = 0;
  };

  // `held`: the components that supports fix, per node. Nodes without an element stay in place.
  // Throws std::invalid_argument: a parameter, an element without positive volume, an invalid mesh;
  // Interrupted. In statics `progress` must outlive the model: searches for equilibrium that take
  // longer than a tenth of a second report their progress to it, and fail when stopped.
  FemModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
           Progress* progress = nullptr);

  void Reset() override;

  // Of the last query.
  // relative, reached
  [[nodiscard]] double residual() const {
    return stepper_ ? stepper_->last_solve().residual : equilibrium_->residual();
  }
  [[nodiscard]] double energy() const;                               // elastic and kinetic [J]
  [[nodiscard]] int inverted() const { return summary().inverted; }  // elements
  [[nodiscard]] const fem::TimeStepper* stepper() const { return stepper_ ? &*stepper_ : nullptr; }

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  bool TryRespond(std::span<const Contact> contacts);
  bool Locate(std::span<const Contact> contacts);
  bool Fail(const char* why, int contact = -1);
  void SetGravity();
  void Describe(const SolidMesh& mesh);
  void Rehearse(const SolidMesh& mesh);
  void RemarkInversion();
  [[nodiscard]] std::optional<std::string_view> FlagReason(
      std::span<const Contact> contacts) noexcept;
  [[nodiscard]] double Softness() noexcept;
  [[nodiscard]] ContactResponse ResponseOf(std::size_t k, const Contact& contact,
                                           std::optional<std::string_view> doubt) const noexcept;
  [[nodiscard]] const fem::NodeVector& displacement() const {
    return stepper_ ? stepper_->displacement() : equilibrium_->displacement();
  }
  [[nodiscard]] const fem::ElementSummary& summary() const {
    return stepper_ ? stepper_->summary() : equilibrium_->summary();
  }

  Params params_;
  fem::FemBody body_;
  double length_unit_, force_unit_, time_unit_;  // [m], [N], [s]
  fem::Constraints constraints_;
  fem::ContactSet contacts_;
  std::optional<fem::StaticEquilibrium> equilibrium_;
  std::optional<fem::TimeStepper> stepper_;
  fem::NodeVector gravity_, f_ext_;
  StrainResolution strain_;
  std::vector<Eigen::Vector3d> u_;  // of the nodes
  std::vector<int> touched_;
  std::string remark_, failure_text_;
};

}  // namespace palpate
