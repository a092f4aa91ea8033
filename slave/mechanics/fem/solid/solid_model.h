// `fem` for accuracy and large strains: quadrature-based tetrahedra with four or ten nodes,
// constitutive models linear, corotational and hyperelastic, with or without a pressure unknown,
// static or dynamic. At rest a rigid tool holds the nodes that it touches: after each equilibrium
// nodes that pull are released and nodes inside the tool begin to touch, until none changes. A
// flat face holds whole nodes, those within it. The parts are documented in elastic_body.h,
// material_law.h, equilibrium.h.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/solid/elastic_body.h"
#include "slave/mechanics/fem/solid/equilibrium.h"
#include "slave/mechanics/fem/solid/solid_motion.h"
#include "slave/mechanics/fem/solid/solid_params.h"
#include "slave/mechanics/fem/solid/solid_state.h"
#include "slave/mechanics/fem/solid/solid_statics.h"
#include "slave/mechanics/fem/solid/sparse_system.h"
#include "slave/mechanics/fem/solid/supports.h"
#include "slave/mechanics/fem/volume_model.h"
#include "slave/mechanics/tet_mesh.h"
#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

class SolidModel final : public VolumeModel {
 public:
  using Params = SolidParams;

  // `held`: components of every node of `mesh` that stay in place; a mid-edge node is fixed if both
  // ends of its edge are. Throws std::invalid_argument: see Checked; a mesh with bad tetrahedra, or
  // one whose direct factor exceeds the limits where the pressure is an unknown; Interrupted. In
  // statics `progress` must outlive the model: searches for equilibrium that take longer than a
  // tenth of a second report their progress to it, and fail when stopped.
  SolidModel(const SolidMesh& mesh, const HeldNodes& held, const Params& params,
             Progress* progress = nullptr);

  [[nodiscard]] const TetMesh& mesh() const { return mesh_; }
  // Returns the displacement of node `node` of mesh(), which may be a mid-edge node [m].
  [[nodiscard]] Eigen::Vector3d displacement(int node) const {
    return traits_.length_unit * DisplacementAt(node);
  }
  // Pressure unknown of a vertex, positive in tension [Pa]; 0 without pressure unknowns.
  [[nodiscard]] double pressure(int vertex) const {
    return layout_.has_pressure() ? params_.young_modulus * state_.x[layout_.pressure(vertex)] : 0;
  }
  [[nodiscard]] int newton_steps() const {
    return motion_ ? equilibrium_.newton_steps() : statics_.newton_steps();
  }

 private:
  void Rest() override;
  bool Hold(std::span<const Contact> contacts) override;
  bool SolveUnder(std::span<const Contact> contacts) override;
  void TakeBack() override {
    if (motion_) motion_->TakeBack();
  }
  [[nodiscard]] Eigen::Vector3d DisplacementAt(int node) const override {
    return state_.x.segment<3>(layout_.first(node));
  }
  [[nodiscard]] Eigen::Vector3d ReactionAt(int node) const override {
    return equilibrium_.unbalanced().segment<3>(layout_.first(node));
  }
  [[nodiscard]] Eigen::Vector3d PointForce(std::size_t contact) const override {
    return state_.balance.row_force.segment<3>(first_row_[contact]);
  }
  [[nodiscard]] Inversion FindInversion() const override;
  [[nodiscard]] bool gained_energy() const override { return motion_ && motion_->grew(); }
  void Describe(Progress* progress);
  bool Prescribe(std::span<const Contact> contacts);
  // The part of a contact's displacement that the node `k` of its place follows.
  [[nodiscard]] double FollowedPart(const Contact& contact, const ContactPlace& place,
                                    std::size_t k) const;
  void FixTouched();
  void GuessTouching(std::span<const Contact> contacts);
  bool ChangeTouching(std::span<const Contact> contacts);
  [[nodiscard]] int Touching(std::size_t contact) const override {
    return static_cast<int>(std::ranges::count(touches_[contact], 1));
  }
  [[nodiscard]] bool settles() const override { return is_settled_; }

  Params params_;
  TetMesh mesh_;
  BlockLayout layout_;
  ElasticBody body_;
  fem::SearchProgress progress_;
  Equilibrium equilibrium_;
  Supports supports_;

  Eigen::VectorXd weight_;  // gravity's load
  SolidState state_;
  std::vector<std::vector<char>> touches_;  // per contact and node of its place
  std::vector<char> presses_;               // per contact: its tool is deeper than a node's gap
  bool is_settled_ = true;
  std::vector<int> first_row_;  // per contact that moves a point: the first of its rows
  SolidStatics statics_;
  std::optional<SolidMotion> motion_;  // nullopt: at rest
};

}  // namespace palpate
