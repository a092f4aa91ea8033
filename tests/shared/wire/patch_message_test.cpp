#include "shared/wire/patch_message.h"

#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/geometry/symmetric_eigen.h"
#include "shared/patch/patch_place.h"

namespace palpate {
namespace {

// The largest there may be: 204 vertices, 200 triangles, 32 coupled nodes, five tools.
SurfacePatch Largest() {
  SurfacePatch patch;
  patch.epoch = 4'000'000'000;
  patch.settings_revision = 100;
  patch.vertices_per_cell = 3;
  patch.vertex_count = kPatchVertices;
  patch.cell_count = kPatchCells;
  patch.node_count = kPatchNodes;
  for (int i = 0; i < kPatchVertices; ++i) {
    const auto at = static_cast<std::size_t>(i);
    patch.vertices[at] = {1e-3F * static_cast<float>(i / 2), 1e-3F * static_cast<float>(i % 2),
                          0.F};
    patch.node_of[at] = static_cast<std::uint8_t>(i % kPatchNodes);
  }
  for (int i = 0; i < kPatchCells; ++i) {
    const auto a = static_cast<std::uint8_t>(i);
    const bool even = i % 2 == 0;
    patch.cells[static_cast<std::size_t>(i)] = {a, static_cast<std::uint8_t>(even ? i + 2 : i + 1),
                                                static_cast<std::uint8_t>(even ? i + 1 : i + 2)};
  }
  patch.coupled = true;
  const int size = 3 * kPatchNodes;
  patch.compliance.setConstant(size, size, 1e-4F);
  patch.compliance.diagonal().setConstant(1e-3F);
  patch.tool_count = kPatchTools;
  for (PatchTool& tool : patch.tools) tool = {{1e-3, -2e-3, 3e-3}, 5e-3};
  patch.full_depth = 5e-3;
  patch.valid_depth = 9e-3;
  return patch;
}

PatchLaw LargestLaw() {
  PatchLaw law;
  law.epoch = law.revision = 4'000'000'000;
  for (std::size_t i = 0; i < law.ratios.size(); ++i)
    law.ratios[i] = 1 + 0.1 * static_cast<double>(i);
  law.friction = 0.4;
  law.offset = {1e-3, 2e-3, 3e-3};
  law.velocity = {1e-2, -1e-2, 5e-3};
  law.velocity_error = 1e-3;
  law.sensed_at = Time(std::chrono::nanoseconds(4'102'444'799'999'999'999));
  return law;
}

v1::SurfacePatch FullPatch() {
  v1::SurfacePatch message;
  ToProto(Largest(), &message);
  return message;
}

// Reference: proto/README.md: at most 64 kB once and 256 bytes per update. Numbers are sent as
// float.
TEST(PatchMessageTest, TheLargestMessageFitsAndIsReadUnchanged) {
  const v1::SurfacePatch message = FullPatch();
  EXPECT_LE(message.ByteSizeLong(), kMaxPatchBytes);
  std::string reason;
  const auto patch = FromProto(message, &reason);
  ASSERT_TRUE(patch) << reason;
  const SurfacePatch sent = Largest();
  EXPECT_EQ(patch->cell_count, sent.cell_count);
  EXPECT_EQ(patch->cells, sent.cells);
  EXPECT_EQ(patch->node_of, sent.node_of);
  EXPECT_EQ(patch->compliance, sent.compliance);
  EXPECT_TRUE(patch->coupled);
  EXPECT_EQ(patch->tool_count, sent.tool_count);
  EXPECT_NEAR(patch->tools[4].radius, 5e-3, 1e-9);
  EXPECT_NEAR(patch->full_depth, 5e-3, 1e-9);
  v1::SurfacePatch again;
  ToProto(*patch, &again);
  EXPECT_EQ(again.SerializeAsString(), message.SerializeAsString());
}

TEST(PatchMessageTest, TheLargestLawFitsIntoAState) {
  v1::PatchUpdate update;
  ToProto(LargestLaw(), update.mutable_law());
  EXPECT_LE(update.ByteSizeLong(), kMaxLawBytes);
  std::string reason;
  const auto law = FromProto(update.law(), &reason);
  ASSERT_TRUE(law) << reason;
  for (std::size_t i = 0; i < law->ratios.size(); ++i) {
    EXPECT_NEAR(law->ratios[i], LargestLaw().ratios[i], 1e-6);
  }
  EXPECT_NEAR(*law->friction, 0.4, 1e-7);
  EXPECT_LT((law->velocity - LargestLaw().velocity).norm(), 1e-8);
  EXPECT_EQ(law->sensed_at, LargestLaw().sensed_at);
}

// Reference: a spring. A matrix that is no spring is replaced by the nearest spring.
TEST(PatchMessageTest, AComplianceThatWouldGiveEnergyIsMadePassive) {
  v1::SurfacePatch message = FullPatch();
  message.set_compliance(1, 0.5F);  // beside a diagonal of 1e-3
  std::string reason;
  const auto patch = FromProto(message, &reason);
  ASSERT_TRUE(patch) << reason;
  const Eigen::MatrixXd C = patch->compliance.cast<double>();
  EXPECT_GE(EigenOf(C).values.minCoeff(), -1e-7);
}

struct Harm {
  const char* reason;  // word that the error message contains
  std::function<void(v1::SurfacePatch*)> apply;
};

class MaliciousPatchTest : public testing::TestWithParam<Harm> {};

TEST_P(MaliciousPatchTest, IsRefusedAndNamed) {
  v1::SurfacePatch message = FullPatch();
  GetParam().apply(&message);
  std::string reason;
  EXPECT_FALSE(FromProto(message, &reason));
  EXPECT_THAT(reason, testing::HasSubstr(GetParam().reason));
}

constexpr float kFloatNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kFloatInf = std::numeric_limits<float>::infinity();
using M = v1::SurfacePatch;

INSTANTIATE_TEST_SUITE_P(
    Rows, MaliciousPatchTest,
    testing::Values(Harm{"epoch", [](M* m) { m->set_epoch(0); }},
                    Harm{"vertices", [](M* m) { m->set_vertices(3, kFloatNan); }},
                    Harm{"vertices", [](M* m) { m->add_vertices(1); }},
                    Harm{"vertices", [](M* m) { m->mutable_vertices()->Resize(3'000'000, 0.F); }},
                    Harm{"cells", [](M* m) { m->set_cells(5, 0xFFFFFFFF); }},
                    Harm{"cells", [](M* m) { m->set_cells(1, m->cells(0)); }},
                    Harm{"nodes", [](M* m) { m->set_nodes(0, 32); }},
                    Harm{"nodes", [](M* m) { m->mutable_nodes()->Resize(1'000'000, 0); }},
                    Harm{"directions", [](M* m) { m->set_directions(2); }},
                    Harm{"compliance", [](M* m) { m->set_compliance(0, kFloatNan); }},
                    Harm{"compliance", [](M* m) { m->add_compliance(0); }},
                    Harm{"compliance", [](M* m) { m->set_compliance(0, -1e-3F); }},
                    Harm{"compliance",
                         [](M* m) {
                           for (float& value : *m->mutable_compliance()) value = 0;
                         }},
                    Harm{"tools", [](M* m) { m->add_tools(); }},
                    Harm{"tools.radius", [](M* m) { m->mutable_tools(0)->set_radius(-1); }},
                    Harm{"full_depth", [](M* m) { m->set_full_depth(0); }},
                    Harm{"valid_depth", [](M* m) { m->set_valid_depth(-1); }}));

TEST(PatchMessageTest, ALawThatIsNoneIsRefused) {
  const std::vector<std::function<void(v1::PatchLaw*)>> rows{
      [](v1::PatchLaw* m) { m->set_epoch(0); },
      [](v1::PatchLaw* m) { m->clear_ratios(); },
      [](v1::PatchLaw* m) { m->add_ratios(1); },
      [](v1::PatchLaw* m) { m->set_ratios(3, kFloatNan); },
      [](v1::PatchLaw* m) { m->set_friction(-0.1F); },
      [](v1::PatchLaw* m) { m->set_velocity_error(-1); },
      [](v1::PatchLaw* m) { m->mutable_sensed_at()->set_nanos(-1); }};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    v1::PatchLaw message;
    ToProto(LargestLaw(), &message);
    rows[i](&message);
    std::string reason;
    EXPECT_FALSE(FromProto(message, &reason)) << i;
    EXPECT_FALSE(reason.empty()) << i;
  }
}

}  // namespace
}  // namespace palpate
