#include <cmath>
#include <limits>

#include "shared/validation/validation.h"

namespace palpate {
namespace {

constexpr double kUnitTolerance = 1e-6;  // of the norm of a unit vector in double precision [-]
// Largest asymmetry of a matrix of floats relative to its largest entry [-]: rounding of both
// halves.
constexpr float kAsymmetry = 4 * std::numeric_limits<float>::epsilon();

// Collects the first violation.
class Invariants {
 public:
  void Require(bool holds, const char* violation) {
    if (!holds && first_.empty()) first_ = violation;
  }
  void Finite(double value, const char* name) {
    if (!std::isfinite(value)) Name(name, value, "is not finite");
  }
  void NotNegative(double value, const char* name) {
    if (!std::isfinite(value) || value < 0) Name(name, value, "is not finite and at least 0");
  }
  void Positive(double value, const char* name) {
    if (!std::isfinite(value) || value <= 0) Name(name, value, "is not finite and above 0");
  }
  template <class Derived>
  void Finite(const Eigen::DenseBase<Derived>& value, const char* name) {
    if (!value.allFinite() && first_.empty()) first_ = std::string(name) + " is not finite";
  }
  void Unit(double norm, const char* name) {
    if (!(std::abs(norm - 1) <= kUnitTolerance)) Name(name, norm, "is not of length 1");
  }
  std::string Take() { return std::move(first_); }

 private:
  void Name(const char* name, double value, const char* why) {
    if (first_.empty()) first_ = std::string(name) + " = " + std::to_string(value) + " " + why;
  }
  std::string first_;
};

void RequireLocalModel(const LocalModel& model, Invariants* all) {
  if (!model.known()) return;
  all->Finite(model.reference, "local_model.reference");
  all->Unit(model.normal.norm(), "local_model.normal");
  all->Finite(model.force, "local_model.force");
  all->Finite(model.stiffness, "local_model.stiffness");
  all->Positive(model.valid_radius, "local_model.valid_radius");
}

void RequireFinger(const FingerState& finger, Invariants* all) {
  all->Finite(finger.p_S_contact, "fingers.p_S_contact");
  if (finger.force) all->Finite(*finger.force, "fingers.force");
  all->Require(finger.force || !IsForceKnown(finger.validity),
               "fingers.force is absent, but its validity says that it is known");
}

void RequireDetails(const CheckDetails& details, Invariants* all) {
  const auto values = ValuesOf(details);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i]) all->Finite(*values[i], kCheckColumns[i].data());
  }
}

void RequireEstimate(const ContactEstimate& estimate, Invariants* all) {
  all->Finite(estimate.p_S_tip, "p_S_tip");
  all->Finite(estimate.p_S_contact, "p_S_contact");
  all->NotNegative(estimate.depth, "depth");
  all->Require(estimate.force || !IsForceKnown(estimate.validity),
               "force is absent, but validity says that it is known");
  all->Require(estimate.validity != Validity::kValid || estimate.check == FailedCheck::kNone,
               "validity is valid, but a check failed");
  all->NotNegative(estimate.sigma, "sigma");
  all->NotNegative(estimate.moment_sigma, "moment_sigma");
  if (estimate.force) all->Finite(*estimate.force, "force");
  if (estimate.moment) all->Finite(*estimate.moment, "moment");
  RequireLocalModel(estimate.local_model, all);
  all->Require(estimate.finger_count >= 0 && estimate.finger_count <= kMaxFingers,
               "finger_count is not from 0 to kMaxFingers");
  for (int i = 0; i < std::min(estimate.finger_count, kMaxFingers); ++i) {
    RequireFinger(estimate.fingers[static_cast<std::size_t>(i)], all);
  }
  RequireDetails(estimate.details, all);
}

void RequireIndices(const SurfacePatch& patch, Invariants* all) {
  for (int i = 0; i < patch.vertex_count; ++i) {
    all->Finite(patch.vertices[static_cast<std::size_t>(i)], "vertices");
    all->Require(patch.node_of[static_cast<std::size_t>(i)] < patch.node_count,
                 "node_of names a node that is not there");
  }
  for (int i = 0; i < patch.cell_count; ++i) {
    for (int corner = 0; corner < patch.vertices_per_cell; ++corner) {
      all->Require(patch.cells[static_cast<std::size_t>(i)][static_cast<std::size_t>(corner)] <
                       patch.vertex_count,
                   "cells names a vertex that is not there");
    }
  }
}

void RequireCompliance(const SurfacePatch& patch, Invariants* all) {
  const auto& C = patch.compliance;
  all->Require(C.rows() == C.cols() && C.rows() == patch.directions * patch.node_count,
               "compliance is not square with `directions` rows for each node");
  all->Finite(C, "compliance");
  if (C.rows() != C.cols() || C.size() == 0) return;
  const float largest = C.cwiseAbs().maxCoeff();
  all->Require((C - C.transpose()).cwiseAbs().maxCoeff() <= kAsymmetry * largest,
               "compliance is not symmetric");
  all->Require(C.diagonal().minCoeff() > 0, "compliance has a diagonal entry that is not above 0");
}

}  // namespace

std::string FirstViolation(const ContactEstimate& estimate) {
  Invariants all;
  RequireEstimate(estimate, &all);
  return all.Take();
}

std::string FirstViolation(const SlaveState& state) {
  Invariants all;
  RequireEstimate(state, &all);
  all.NotNegative(state.echo_delay, "echo_delay");
  all.Finite(state.offset, "offset");
  if (state.true_force) all.Finite(*state.true_force, "true_force");
  all.Require(state.epoch > 0 || state.phase != Phase::kFollowing, "epoch = 0 while following");
  all.Require(state.sensed_at <= state.sent_at, "sensed_at is later than sent_at");
  return all.Take();
}

std::string FirstViolation(const OperatorCommand& command) {
  Invariants all;
  all.Require(command.sequence > 0, "sequence = 0");
  all.Require(command.epoch > 0 || !command.engaged, "epoch = 0 while engaged");
  all.Finite(command.p_M, "p_M");
  all.Finite(command.velocity, "velocity");
  if (command.R_M_device) all.Unit(command.R_M_device->norm(), "R_M_device");
  return all.Take();
}

std::string FirstViolation(const SurfacePatch& patch) {
  if (!patch.known()) return {};
  Invariants all;
  all.Require(patch.vertex_count > 0 && patch.vertex_count <= kPatchVertices,
              "vertex_count is not from 1 to kPatchVertices");
  all.Require(patch.cell_count >= 0 && patch.cell_count <= kPatchCells,
              "cell_count is not from 0 to kPatchCells");
  all.Require(patch.node_count > 0 && patch.node_count <= kPatchNodes,
              "node_count is not from 1 to kPatchNodes");
  all.Require(patch.tool_count > 0 && patch.tool_count <= kPatchTools,
              "tool_count is not from 1 to kPatchTools");
  if (std::string counts = all.Take(); !counts.empty()) return counts;
  RequireIndices(patch, &all);
  RequireCompliance(patch, &all);
  for (int i = 0; i < patch.tool_count; ++i) {
    const PatchTool& tool = patch.tools[static_cast<std::size_t>(i)];
    all.Finite(tool.centre, "tools.centre");
    all.NotNegative(tool.radius, "tools.radius");
  }
  all.Unit(patch.normal.norm(), "normal");
  all.Positive(patch.full_depth, "full_depth");
  all.Positive(patch.valid_depth, "valid_depth");
  return all.Take();
}

std::string FirstViolation(const PatchLaw& law) {
  Invariants all;
  all.Require(law.count > 0 && law.count <= kLawPoints, "count is not from 1 to kLawPoints");
  for (const double ratio : law.ratios) all.NotNegative(ratio, "ratios");
  if (law.friction) all.NotNegative(*law.friction, "friction");
  all.Finite(law.offset, "offset");
  all.Finite(law.velocity, "velocity");
  all.NotNegative(law.velocity_error, "velocity_error");
  return all.Take();
}

std::string FirstViolation(const SolidMesh& mesh) {
  Invariants all;
  for (const Eigen::Vector3d& node : mesh.nodes) all.Finite(node, "nodes");
  const int count = static_cast<int>(mesh.nodes.size());
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    for (const int node : mesh.tets[i]) {
      if (node < 0 || node >= count) return "tets names a node that is not there";
    }
    all.Positive(SignedVolume(mesh, static_cast<int>(i)), "volume of a tetrahedron");
  }
  all.Require(mesh.modulus.empty() || mesh.modulus.size() == mesh.tets.size(),
              "modulus does not have one number for each tetrahedron");
  for (const double modulus : mesh.modulus) all.Positive(modulus, "modulus");
  return all.Take();
}

}  // namespace palpate
