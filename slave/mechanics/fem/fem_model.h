// `fem` with linear tetrahedra: linear or co-rotational, in equilibrium or in motion, or
// neo-Hookean in equilibrium. Eight elements per instruction.
//
// The law is that of Mueller and Gross (2004), paper B [21], with the signed polar rotation
// (fem/tet_elements.h), or the neo-Hookean one of solid/material_law.h; equilibria by Newton's
// method (fem/static_equilibrium.h), motion by implicit Euler (fem/time_stepper.h). Linear
// tetrahedra are first order accurate in stress and lock as nu approaches 0.5.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/static_equilibrium.h"
#include "slave/mechanics/fem/time_stepper.h"
#include "slave/mechanics/fem/volume_model.h"
#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

class FemModel final : public VolumeModel {
 public:
  struct Params {
    Material material;   // E > 0 [Pa], -1 < nu < 0.5; a density wherever mass counts
    FemOptions options;  // tet4, no Ogden's law, pressure from the displacement
    // Largest |displacement| / larger side before `extrapolated` [-]; 0: 0.1 in the linear law,
    // none in the others.
    double range = 0;
    // For static models: time after which an update returns its present result, as `extrapolated`
    // unless it reached the residual [s]. One step is always made. 0: no limit.
    double deadline = 0;
    // For static models. Moving contacts that have a width or a radius, or any if `tool` is not
    // flat, are rigid tools that first touch at p_O. The set of nodes that touch them changes.
    // Bonded: nodes that touch stick until they are pulled. Their force depends on their path,
    // which is assumed straight between two queries. The body must be fixed by supports, else a
    // flat bonded tool moves its patch as a whole, as in motion.
    ContactLaw contact = ContactLaw::kBonded;
    double friction = 0;  // Coulomb's coefficient, with kFriction [-]
    Tool tool{};          // of contacts without a radius
  };

  // `held`: the components that supports fix, per node. Nodes without an element stay in place.
  // Throws std::invalid_argument: a parameter, an element without positive volume, an invalid mesh;
  // Interrupted. In statics `progress` must outlive the model: searches for equilibrium that take
  // longer than a tenth of a second report their progress to it, and fail when stopped.
  FemModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
           Progress* progress = nullptr);

  // Returns the relative residual of the last query.
  [[nodiscard]] double residual() const {
    return stepper_ ? stepper_->last_solve().residual : equilibrium_->residual();
  }
  // At rest, of the last query: steps of Newton's method, iterations of their linear systems.
  [[nodiscard]] int newton_steps() const { return equilibrium_ ? equilibrium_->newton_steps() : 1; }
  [[nodiscard]] int iterations() const { return equilibrium_ ? equilibrium_->iterations() : 0; }
  [[nodiscard]] double energy() const;  // elastic and kinetic [J]
  [[nodiscard]] int inverted() const { return inversion().elements; }
  [[nodiscard]] const fem::TimeStepper* stepper() const { return stepper_ ? &*stepper_ : nullptr; }

 private:
  void Rest() override;
  bool Hold(std::span<const Contact> contacts) override;
  bool SolveUnder(std::span<const Contact> contacts) override;
  void TakeBack() override;
  [[nodiscard]] Eigen::Vector3d DisplacementAt(int node) const override {
    return VectorAt(stepper_ ? stepper_->displacement() : equilibrium_->displacement(), node);
  }
  [[nodiscard]] Eigen::Vector3d ReactionAt(int node) const override {
    return VectorAt(reaction(), node);
  }
  [[nodiscard]] Eigen::Vector3d PointForce(std::size_t contact) const override {
    return constraints_.Sum(hold_[contact], reaction());
  }
  [[nodiscard]] Inversion FindInversion() const override;
  [[nodiscard]] double ErrorOf(std::size_t contact) const override;
  [[nodiscard]] bool ended_early() const override {
    return equilibrium_ && (equilibrium_->ended_early() || jumped_);
  }
  [[nodiscard]] bool follows_path() const override { return tools_ && !tools_->empty(); }
  [[nodiscard]] bool gained_energy() const override {
    return stepper_ && stepper_->gained_energy();
  }
  [[nodiscard]] const fem::ToolContact* ToolOf(std::size_t contact) const override {
    return tool_[contact] >= 0 ? &tools_->at(tool_[contact]) : nullptr;
  }
  [[nodiscard]] bool IsTool(const Contact& contact) const;
  [[nodiscard]] Tool ToolAt(const Contact& contact) const;
  bool HoldTools(std::span<const Contact> contacts);
  bool MoveTools(std::span<const Contact> contacts);
  // Prescribes the contacts interpolated between the last accepted ones (`part` 0) and the new ones
  // (1).
  bool Prescribe(std::span<const Contact> contacts, double part);
  void SetGravity();
  void Describe();
  void MeasureUpdateTime(const SolidMesh& mesh);
  [[nodiscard]] const fem::NodeVector& reaction() const {
    return stepper_ ? stepper_->reaction() : equilibrium_->reaction();
  }
  [[nodiscard]] Eigen::Vector3d VectorAt(const fem::NodeVector& of, int mesh_node) const {
    return Eigen::Map<const Eigen::Vector3d>(fem::At(of, body_.Number(mesh_node)).v);
  }
  [[nodiscard]] const fem::ElementSummary& summary() const {
    return stepper_ ? stepper_->summary() : equilibrium_->summary();
  }

  Params params_;
  fem::FemBody body_;
  double time_unit_;  // [s]
  fem::Constraints constraints_;
  std::optional<fem::StaticEquilibrium> equilibrium_;
  std::optional<fem::TimeStepper> stepper_;
  fem::NodeVector gravity_, f_ext_;
  std::vector<int> hold_;  // per contact: its number in constraints_; -1: none
  std::optional<fem::ToolContacts> tools_;
  std::vector<int> tool_;  // per contact: its number in tools_; -1: none
  // Last prescribed contacts, if there are tools.
  std::vector<Contact> accepted_, former_, kept_;
  bool jumped_ = false;             // the deadline left the rest of a path to one increment
  bool holds_patches_ = false;      // flat bonded tools move their patch as a whole
  std::vector<PlaceWeight> moved_;  // scratch: a contact's nodes by their numbers in the body
};

}  // namespace palpate
