// `fem` and `fem-hyperelastic` for accuracy: quadrature-based tetrahedra with four or ten nodes,
// constitutive models linear, corotational and stable neo-Hookean, with or without a pressure
// unknown, static or dynamic. The parts are documented in elastic_body.h, material_law.h,
// equilibrium.h.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/fem/solid/contact_set.h"
#include "slave/mechanics/fem/solid/elastic_body.h"
#include "slave/mechanics/fem/solid/element_mesh.h"
#include "slave/mechanics/fem/solid/equilibrium.h"
#include "slave/mechanics/fem/solid/sparse_system.h"
#include "slave/mechanics/fem/solid/supports.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/scene/scene.h"

namespace palpate {

// A contact that moves nodes also reports what holds them. Inverted elements, with the linear law
// displacements beyond the range, and a mesh too coarse for a patch or for a part that bends:
// kExtrapolated. Displacements beyond 1e6 larger sides are absurd: kFailed. After a failure the
// body is at rest again.
class SolidModel final : public DeformationModel {
 public:
  struct Params {
    FemOptions options;        // threads: one is used
    double young_modulus = 0;  // E [Pa]
    double poisson_ratio = 0;  // -1 < nu <= 0.5
    double density = 0;        // [kg/m^3], > 0 where there is gravity or time
    double range = 0.1;        // of the linear law: largest |displacement| / larger side
    SymmetricSolver::Limits limits;
  };

  // `held`: components of every node of `mesh` that stay in place; the middle of an edge is fixed
  // where both its ends are. Throws std::invalid_argument: an impossible parameter or combination,
  // a mesh with bad tetrahedra; Interrupted.
  //
  // Pressure: ten nodes take `mixed` (any nu > 0 up to and including 0.5 for the linear law, up to
  // kNearlyIncompressible for others), four take `averaged` (up to 0.4999). `mixed` and `averaged`
  // need a direct factor within the limits.
  SolidModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
             Progress* progress = nullptr);
  static constexpr double kNearlyIncompressible = 0.49999;
  static constexpr double kAveragedLimit = 0.4999;

  void Reset() override;
  void Start(std::span<const Contact> contacts) override;

  [[nodiscard]] const ElementMesh& mesh() const { return mesh_; }
  // Of node `node` of mesh(), middles too [m].
  [[nodiscard]] Eigen::Vector3d displacement(int node) const {
    return unit_ * x_.segment<3>(layout_.first(node));
  }
  // Pressure unknown of a vertex, positive in tension [Pa]; 0 without pressure unknowns.
  [[nodiscard]] double pressure(int vertex) const {
    return layout_.has_pressure() ? params_.young_modulus * x_[layout_.pressure(vertex)] : 0;
  }
  // Elastic, and elastic plus kinetic energy of the state [J].
  [[nodiscard]] double elastic_energy() {
    return params_.young_modulus * unit_ * unit_ * unit_ * equilibrium_.Energy(x_);
  }
  [[nodiscard]] double total_energy();
  [[nodiscard]] int newton_steps() const { return newton_steps_; }
  [[nodiscard]] double smallest_jacobian() const { return body_.SmallestJacobian(x_); }

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  void Describe(Progress* progress);
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool Acceptable(std::span<const Contact> contacts);
  bool PrepareSet(std::span<const Contact> contacts);
  bool Prescribe(std::span<const Contact> contacts);
  bool SolveStatic();
  bool SolveInParts();
  bool CheckFreeBody();
  bool SolveStep();
  void PrepareStep();
  void FinishStep();
  [[nodiscard]] double total_energy_nondimensional();
  [[nodiscard]] bool EnergyGrew();
  [[nodiscard]] std::optional<std::string_view> FlagReason(double largest);
  [[nodiscard]] double Softness();
  bool Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  [[nodiscard]] Eigen::Vector3d ForceOn(const ContactPlace& place) const;
  [[nodiscard]] bool dynamic() const { return params_.options.time == FemOptions::Time::kDynamic; }
  // Without a pressure of their own four-node elements are too stiff near nu = 0.5.
  [[nodiscard]] bool locks() const;
  [[nodiscard]] bool newmark() const {
    return params_.options.integrator == FemOptions::Integrator::kNewmark;
  }

  Params params_;
  double unit_;  // larger side of the body [m]
  ElementMesh mesh_;
  BlockLayout layout_;
  ElasticBody body_;
  Equilibrium equilibrium_;
  std::vector<bool> used_;
  SolidContacts contacts_;
  Supports supports_;
  std::optional<StrainResolution> strain_;  // of four nodes
  std::vector<Eigen::Vector3d> u_;          // of the nodes
  std::vector<int> touched_;

  Balance balance_;
  Eigen::VectorXd weight_;          // gravity's load
  Eigen::VectorXd target_, loads_;  // where `given` and `force` go
  Eigen::VectorXd x_, start_, good_, start_loads_;
  std::vector<double> row_target_, row_start_;
  // Of time: mass, damping, Q; velocity; forces at the start of a step (Newmark).
  SparseMatrix mass_, damping_, inertia_;
  Eigen::VectorXd velocity_, start_velocity_, start_forces_, product_;
  bool step_ready_ = false, grew_ = false, inverted_ = false;
  double start_energy_ = 0;
  int newton_steps_ = 0;
};

}  // namespace palpate
