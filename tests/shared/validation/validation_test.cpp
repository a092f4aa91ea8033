#include "shared/validation/validation.h"

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/not_finite.h"

namespace palpate {
namespace {

ContactEstimate PressedEstimate() {
  ContactEstimate estimate;
  estimate.Set({Validity::kValid});
  estimate.force = Eigen::Vector3d(0, 1, 0);
  estimate.sigma = 0.1;
  estimate.depth = 1e-3;
  estimate.local_model.revision = 1;
  estimate.local_model.valid_radius = 1e-2;
  return estimate;
}

SlaveState FollowingState() {
  SlaveState state;
  static_cast<ContactEstimate&>(state) = PressedEstimate();
  state.phase = Phase::kFollowing;
  state.epoch = 1;
  return state;
}

OperatorCommand EngagedCommand() {
  OperatorCommand command;
  command.sequence = command.epoch = 1;
  command.engaged = true;
  return command;
}

// A plane of one node.
SurfacePatch PlanePatch() {
  SurfacePatch patch;
  patch.epoch = 1;
  patch.vertex_count = patch.node_count = patch.vertices_per_cell = 1;
  patch.compliance = SurfacePatch::Compliance::Identity(3, 3);
  patch.full_depth = patch.valid_depth = 1e-2;
  return patch;
}

SolidMesh OneTetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
}

// Each change breaks one invariant, whose violation begins with `name`.
template <class Value>
struct Change {
  std::string name;
  std::function<void(Value*)> apply;
};

template <class Value>
void ExpectViolations(const Value& valid, const std::vector<Change<Value>>& changes) {
  EXPECT_EQ(FirstViolation(valid), "");
  for (const Change<Value>& change : changes) {
    Value value = valid;
    change.apply(&value);
    EXPECT_TRUE(FirstViolation(value).starts_with(change.name))
        << change.name << ": " << FirstViolation(value);
  }
}

TEST(FirstViolation, OfAnEstimate) {
  ExpectViolations<ContactEstimate>(
      PressedEstimate(),
      {{"p_S_tip", [](auto* it) { it->p_S_tip.x() = kNan; }},
       {"depth = -", [](auto* it) { it->depth = -1; }},
       {"force is absent", [](auto* it) { it->force.reset(); }},
       {"force is not finite", [](auto* it) { it->force->z() = kNan; }},
       {"validity is valid", [](auto* it) { it->check = FailedCheck::kModelRange; }},
       {"sigma", [](auto* it) { it->sigma = INFINITY; }},
       {"moment_sigma", [](auto* it) { it->moment_sigma = -1; }},
       {"local_model.normal", [](auto* it) { it->local_model.normal *= 2; }},
       {"local_model.valid_radius", [](auto* it) { it->local_model.valid_radius = 0; }},
       {"finger_count", [](auto* it) { it->finger_count = kMaxFingers + 1; }},
       {"fingers.force is absent",
        [](auto* it) {
          it->finger_count = 1;
          it->fingers[0].validity = Validity::kValid;
        }},
       {"score", [](auto* it) { it->details.score = kNan; }}});
}

TEST(FirstViolation, OfAState) {
  ExpectViolations<SlaveState>(
      FollowingState(),
      {{"sigma", [](auto* it) { it->sigma = -1; }},
       {"echo_delay", [](auto* it) { it->echo_delay = -1; }},
       {"epoch = 0", [](auto* it) { it->epoch = 0; }},
       {"sensed_at is later", [](auto* it) { it->sensed_at = it->sent_at + Seconds(1); }}});
}

TEST(FirstViolation, OfACommand) {
  ExpectViolations<OperatorCommand>(
      EngagedCommand(),
      {{"sequence = 0", [](auto* it) { it->sequence = 0; }},
       {"epoch = 0", [](auto* it) { it->epoch = 0; }},
       {"p_M", [](auto* it) { it->p_M.y() = kNan; }},
       {"R_M_device", [](auto* it) { it->R_M_device = Eigen::Quaterniond(2, 0, 0, 0); }}});
}

TEST(FirstViolation, OfAPatchAndItsLaw) {
  ExpectViolations<SurfacePatch>(
      PlanePatch(), {{"vertex_count", [](auto* it) { it->vertex_count = kPatchVertices + 1; }},
                     {"node_of", [](auto* it) { it->node_of[0] = 1; }},
                     {"compliance is not square", [](auto* it) { it->compliance.resize(3, 1); }},
                     {"compliance is not symmetric", [](auto* it) { it->compliance(0, 1) = 0.1F; }},
                     {"compliance has a diagonal", [](auto* it) { it->compliance(1, 1) = 0; }},
                     {"full_depth", [](auto* it) { it->full_depth = 0; }}});
  ExpectViolations<PatchLaw>({}, {{"count", [](auto* it) { it->count = 0; }},
                                  {"ratios", [](auto* it) { it->ratios[3] = -1; }}});
}

TEST(FirstViolation, OfTetrahedra) {
  ExpectViolations<SolidMesh>(
      OneTetrahedron(), {{"nodes", [](auto* it) { it->nodes[0].x() = kNan; }},
                         {"tets names", [](auto* it) { it->tets[0][0] = 4; }},
                         {"volume", [](auto* it) { std::swap(it->tets[0][0], it->tets[0][1]); }},
                         {"modulus does not",
                          [](auto* it) {
                            it->modulus = {1, 1};
                          }},
                         {"modulus = 0", [](auto* it) { it->modulus = {0}; }}});
}

TEST(ValidateDeathTest, EndsTheProgramWithValueAndPlace) {
  OperatorCommand command = EngagedCommand();
  command.sequence = 0;
  Validate(EngagedCommand(), "Here");
  EXPECT_DEATH(Validate(command, "Here"), "Here: invariant violated: sequence = 0");
}

}  // namespace
}  // namespace palpate
