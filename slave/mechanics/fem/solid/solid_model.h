// `fem` for accuracy and large strains: quadrature-based tetrahedra with four or ten nodes,
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
#include "slave/mechanics/fem/solid/solid_motion.h"
#include "slave/mechanics/fem/solid/solid_params.h"
#include "slave/mechanics/fem/solid/solid_state.h"
#include "slave/mechanics/fem/solid/solid_statics.h"
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
  using Params = SolidParams;

  // `held`: components of every node of `mesh` that stay in place; the middle of an edge is fixed
  // where both its ends are. Throws std::invalid_argument: see Checked; a mesh with bad tetrahedra,
  // or one whose direct factor exceeds the limits where the pressure is an unknown; Interrupted. In
  // statics `progress` must outlive the model: searches for equilibrium that take longer than a
  // tenth of a second report their progress to it, and fail when stopped.
  SolidModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
             Progress* progress = nullptr);

  void Reset() override;

  [[nodiscard]] const ElementMesh& mesh() const { return mesh_; }
  // Of node `node` of mesh(), middles too [m].
  [[nodiscard]] Eigen::Vector3d displacement(int node) const {
    return unit_ * state_.x.segment<3>(layout_.first(node));
  }
  // Pressure unknown of a vertex, positive in tension [Pa]; 0 without pressure unknowns.
  [[nodiscard]] double pressure(int vertex) const {
    return layout_.has_pressure() ? params_.young_modulus * state_.x[layout_.pressure(vertex)] : 0;
  }
  // Elastic and kinetic energy of the state [J].
  [[nodiscard]] double energy();
  [[nodiscard]] int newton_steps() const {
    return motion_ ? equilibrium_.newton_steps() : statics_.newton_steps();
  }
  [[nodiscard]] double smallest_jacobian() const { return body_.SmallestJacobian(state_.x); }

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  void Describe(Progress* progress);
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  bool Acceptable(std::span<const Contact> contacts);
  bool PrepareSet(std::span<const Contact> contacts);
  bool Prescribe(std::span<const Contact> contacts);
  bool SolveState();
  [[nodiscard]] std::optional<std::string_view> FlagReason(double largest);
  [[nodiscard]] double Softness();
  bool Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses);
  [[nodiscard]] Eigen::Vector3d ForceOn(const ContactPlace& place) const;
  void SetMomentOf(const Contact& contact, const ContactPlace& place,
                   ContactResponse* response) const;
  // Without a pressure of their own four-node elements are too stiff near nu = 0.5.
  [[nodiscard]] bool locks() const;

  Params params_;
  double unit_;  // larger side of the body [m]
  ElementMesh mesh_;
  BlockLayout layout_;
  ElasticBody body_;
  fem::SearchProgress progress_;
  Equilibrium equilibrium_;
  std::vector<bool> used_;
  SolidContacts contacts_;
  Supports supports_;
  StrainResolution strain_;
  std::vector<Eigen::Vector3d> u_;  // of the nodes
  std::vector<int> touched_;

  Eigen::VectorXd weight_;  // gravity's load
  SolidState state_;
  SolidStatics statics_;
  std::optional<SolidMotion> motion_;  // nullopt: at rest
  bool inverted_ = false;
};

}  // namespace palpate
