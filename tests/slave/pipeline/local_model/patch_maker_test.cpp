// Compares patches with the model that they are made from. PatchPublisher is tested with a fake
// sense.
#include "slave/pipeline/local_model/patch_maker.h"

#include <memory>
#include <span>
#include <utility>

#include <gtest/gtest.h>

#include "shared/patch/patch_contact.h"
#include "slave/live/patch_publisher.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/index.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d InPlane(const Eigen::Vector2d& v) {
  return {v.x(), v.y(), 0};
}

class OutlinePatchTest : public testing::Test {
 protected:
  OutlinePatchTest()
      : scene_(LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"))),
        mesh_(MeshOutline(scene_, std::nullopt)),
        model_(MakeModel(scene_, mesh_)) {
    for (int i = 0; i < mesh_.size(); ++i) {
      if ((mesh_.elements[Index(i)].midpoint() - Eigen::Vector2d(0.044, 0.088)).norm() < 1.2e-3) {
        top_ = i;
      }
    }
  }
  ContactResponse Respond(const Vector3d& p_O, int element, const Vector3d& displacement) {
    const Contact contact{Contact::Kind::kDisplacement, p_O, element, scene_.tool->width,
                          displacement};
    ContactResponse response;
    model_->Respond(std::span(&contact, 1), std::span(&response, 1));
    return response;
  }
  bool Make(SurfacePatch* patch) {
    const auto stiffness = [this](const Vector3d& p_O, int element, const Vector3d&) -> Matrix3d {
      return Respond(p_O, element, Vector3d::Zero()).stiffness_O;
    };
    const bool known =
        FillPatch(mesh_, top_, Eigen::Isometry3d::Identity(), false, stiffness, patch);
    patch->full_depth = patch->valid_depth = 0.01;
    patch->epoch = 1;
    return known;
  }
  // Returns the relative difference to the slave's own answer for a tip that enters straight at `p`
  // and then moves by `way`.
  double ErrorAt(const SurfacePatch& patch, const Vector3d& p, int element, const Vector3d& n,
                 const Vector3d& way) {
    PatchLaw law;
    law.epoch = law.revision = 1;
    PatchContact contact;
    contact.Take(patch, law, 0, 0);
    contact.ForceAt(p + 1e-3 * n, 1, 1);
    contact.ForceAt(p - 1e-6 * n, 1, 1);
    const Vector3d force = contact.ForceAt(p + way, 1, 1);
    const Vector3d truth = -Respond(p, element, way).force_O;
    return (force - truth).norm() / truth.norm();
  }

  Scene scene_;
  BoundaryMesh mesh_;
  std::unique_ptr<DeformationModel> model_;
  int top_ = -1;
};

// Reference: the slave's own solver. At the nodes (midpoints of elements) the difference is single
// precision and the skew part of K, which collocation creates and a spring must not have (0.3 %).
TEST_F(OutlinePatchTest, AtItsNodesThePatchAgreesWithTheSlavesSolver) {
  ASSERT_GE(top_, 0);
  SurfacePatch patch;
  ASSERT_TRUE(Make(&patch));
  EXPECT_EQ(patch.node_count, kPatchNodes);
  for (int i = -10, at = top_; i < 0; ++i, at = mesh_.Next(at)) {
    const BoundaryElement& e = mesh_.elements[Index(at)];
    const Vector3d n = InPlane(e.normal()), p = InPlane(e.midpoint());
    EXPECT_LT(ErrorAt(patch, p, at, n, -3e-3 * n), 0.005) << i;
    EXPECT_LT(ErrorAt(patch, p, at, n, -3e-3 * n + 1e-3 * InPlane(e.b - e.a).normalized()), 0.01)
        << i;
  }
}

// A sense with a wall of known stiffness.
class WallSense final : public SensingPipeline {
 public:
  double ratio = 1;  // the ratio that LearnLaw receives
  bool has_patch = true;
  bool MakePatch(const Vector3d& p_S_tip, SurfacePatch* patch) noexcept override {
    if (!has_patch) return false;
    *patch = SurfacePatch();
    patch->vertex_count = 2;
    patch->cell_count = patch->node_count = 1;
    patch->vertices[0] = Vector3d(p_S_tip.x() + 0.01, 0, 0).cast<float>();
    patch->vertices[1] = Vector3d(p_S_tip.x() - 0.01, 0, 0).cast<float>();
    patch->cells[0] = {0, 1, 0};
    patch->directions = 1;
    patch->compliance.setConstant(1, 1, 1 / 500.F);
    patch->full_depth = patch->valid_depth = 0.01;
    MarkRim(patch);
    return true;
  }
  void LearnLaw(PatchLaw* law) noexcept override { law->ratios.fill(ratio); }

  bool HasOutgrownPatch() const noexcept override { return false; }
  SurfaceMotion motion() const noexcept override { return {}; }

  bool Acquire(const std::stop_token&) override { return false; }
  void Process() noexcept override {}
  std::string_view flag_reason() const override { return {}; }
  std::optional<OverlaidImage> Image(double) const override { return std::nullopt; }
  TactileInbox* inbox() override { return nullptr; }
  ImageInbox* image_inbox() override { return nullptr; }
  Time sensed_at() const override { return Clock::now(); }
  std::optional<CameraHealth> health() const override { return std::nullopt; }
  const ContactEstimate& Estimate(const TipReading&) noexcept override { return estimate_; }
  LocalModel LocalModelAt(const Vector3d&) noexcept override { return {}; }
  BoundaryShape Shape(const ShapeParts&) override { return {}; }
  std::unique_ptr<PreparedModel> Prepare(const Scene&, Progress*) const override { return nullptr; }
  void Adopt(std::unique_ptr<PreparedModel>, const Scene&) override {}
  void Reset(const std::function<bool()>& /*is_disengaged*/) override {}
  SenseInfo info() const override { return {}; }
  std::vector<StageTimes> Stages() const override { return {}; }
  std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth*) override { return nullptr; }

 private:
  ContactEstimate estimate_;
};

class PatchPublisherTest : public testing::Test {
 protected:
  // Publishes the patch of a sample: the tip is `depth` deep at `x`, and the measured force is
  // `times` that of the wall.
  void Update(double x, double depth, double times, double sigma = 0) {
    now_ += Seconds(1.0 / 60);
    ContactEstimate estimate;
    estimate.sensed_at = now_;
    estimate.p_S_tip = {x, -depth, 0};
    estimate.force = Vector3d(0, depth > 0 ? times * 500 * depth : 0, 0);
    estimate.sigma = sigma;
    estimate.validity = Validity::kValid;
    keeper_.Update(estimate, 1, &sense_, now_);
  }
  PatchSnapshot Get() { return keeper_.Get(now_); }

  WallSense sense_;
  PatchPublisher keeper_{{.weber_fraction = 0.1, .depth = 0.005}};
  Time now_{std::chrono::hours(1)};
};

// Reference: the Weber fraction, 10 %.
TEST_F(PatchPublisherTest, TheLawIsReportedAgainWhereAHandWouldFeelTheDifference) {
  Get();
  Update(0, -1e-3, 1);
  sense_.ratio = 1.05;
  for (int i = 0; i < 30; ++i) Update(0, 2e-3, 1.05);
  EXPECT_EQ(Get().law.revision, 1U) << "too little to be perceived";
  sense_.ratio = 1.3;
  for (int i = 0; i < 30; ++i) Update(0, 2e-3, 1.3);
  EXPECT_EQ(Get().law.revision, 2U) << "reported once, it is right";
  EXPECT_NEAR(Get().law.ratios[0], 1.3, 1e-12);
}

// Each single force is within two sigma of the rendered one; many of them determine the ratio.
TEST_F(PatchPublisherTest, ACurveLearntFromManyForcesIsSentDuringThePress) {
  Get();
  Update(0, -1e-3, 1);
  for (const auto& [ratio, revision] : {std::pair(1.05, 1U), {1.15, 2U}, {1.2, 2U}}) {
    sense_.ratio = ratio;
    for (int i = 0; i < 30; ++i) Update(0, 2e-3, ratio, 0.1);
    EXPECT_EQ(Get().law.revision, revision) << ratio;
  }
  EXPECT_NEAR(Get().law.ratios[0], 1.15, 1e-12);
}

TEST_F(PatchPublisherTest, AToolThatLeavesThePatchGetsAnother) {
  Get();
  Update(0, -1e-3, 1);
  Update(3e-3, -1e-3, 1);
  EXPECT_EQ(Get().patch->epoch, 1U);
  Update(8e-3, -1e-3, 1);
  EXPECT_EQ(Get().patch->epoch, 2U);
  EXPECT_NEAR(Get().patch->vertices[0].x(), 0.018, 1e-6);
}

// Reference: the wall, 500 N/m, which is learnt from the estimates only.
TEST_F(PatchPublisherTest, ASenseWithoutAnObjectModelSendsTheEstimatedLaw) {
  sense_.has_patch = false;
  Get();
  for (int round = 0; round < 20; ++round) {
    for (int i = 0; i <= 20; ++i) Update(0, 4e-3 * i / 20, 1);
    Get();
  }
  const PatchSnapshot news = Get();
  ASSERT_TRUE(news.patch);
  EXPECT_EQ(news.patch->vertices_per_cell, 1);
  PatchContact contact;
  contact.Take(*news.patch, news.law, 0, 0);
  for (const double depth : {1e-3, 2e-3, 3.5e-3}) {
    contact.ForceAt({0, 1e-3, 0}, 1, 1);
    EXPECT_NEAR(contact.ForceAt({0, -depth, 0}, 1, 1).y(), 500 * depth, 0.1 * 500 * depth) << depth;
  }
}

}  // namespace
}  // namespace palpate
