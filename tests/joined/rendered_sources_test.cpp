// The master must render the same force from the same images, whether they come from the simulated
// camera, from a driver or from a slave that records.
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "master/haptics/renderer.h"
#include "slave/capture/image_inbox.h"
#include "slave/live/patch_publisher.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/recording/sense_recording.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/simulator/environment_player.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

constexpr double kImagePeriod = 1.0 / 60;  // of the images [s]
constexpr int kTicksPerImage = 16;
constexpr int kMaxImages = 400;

// Renders one pipeline's estimates as slave and master do, on the clock of the images.
class RenderedForce {
 public:
  RenderedForce(std::unique_ptr<SensingPipeline> sense, const Scene& scene)
      : sense_(std::move(sense)),
        publisher_({.depth = scene.operator_options.press_depth, .period = kImagePeriod}) {}

  [[nodiscard]] SensingPipeline& sense() { return *sense_; }

  // Estimates from the acquired sample and adds the forces of the ticks after it, while the tip
  // moves on from `p_S_tip` [m] with `velocity` [m/s].
  void Add(const Eigen::Vector3d& p_S_tip, const Eigen::Vector3d& velocity) {
    const double sensed = kImagePeriod * ++images_;
    sense_->Process();
    const ContactEstimate& estimate = sense_->Estimate({p_S_tip, std::nullopt});
    const Time now =
        start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(sensed));
    static_cast<void>(publisher_.Get(now));  // a request keeps the patch up to date
    publisher_.Update(estimate, 1, sense_.get(), now);
    const PatchSnapshot sent = publisher_.Get(now);
    if (sent.patch != nullptr && std::pair(sent.law.epoch, sent.law.revision) != law_) {
      law_ = {sent.law.epoch, sent.law.revision};
      renderer_.TakePatch(*sent.patch, sent.law, sensed, sensed);
    }
    SlaveState state;
    state.sequence = static_cast<std::uint64_t>(images_);
    state.sample = static_cast<std::uint64_t>(images_);
    state.validity = estimate.validity;
    state.p_S_tip = p_S_tip;
    state.force = estimate.force;
    state.local_model = estimate.local_model;
    renderer_.Take(state, sensed, sensed, sensed);
    Reasons reasons{};
    for (int tick = 1; tick <= kTicksPerImage; ++tick) {
      const double t = kImagePeriod * tick / kTicksPerImage;
      forces.push_back(renderer_.Render(p_S_tip + t * velocity, sensed + t, &reasons));
    }
  }

  std::vector<Eigen::Vector3d> forces;  // of the object on the tool, one per tick, S [N]

 private:
  const Time start_ = Clock::now();
  std::unique_ptr<SensingPipeline> sense_;
  PatchPublisher publisher_;
  Renderer renderer_{RenderMode::kLocal};
  std::pair<std::uint32_t, std::uint32_t> law_{0, 0};  // epoch and revision
  int images_ = 0;
};

double Peak(const std::vector<Eigen::Vector3d>& forces) {
  double peak = 0;
  for (const Eigen::Vector3d& f : forces) peak = std::max(peak, f.norm());
  return peak;
}

double LargestDifference(const std::vector<Eigen::Vector3d>& a,
                         const std::vector<Eigen::Vector3d>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

TEST(RenderedSourcesTest, SimulatedStreamedAndRecordedImagesRenderTheSameForce) {
  const std::string file = SourcePath("/deploy/scenes/silicone-block.yaml");
  const Scene scene = LoadScene(file, {});
  const Scene streamed_scene = LoadScene(file, {"sense.camera.source=stream"});
  const Scratch folder;
  const auto environment = MakeSimulatedEnvironment(scene);
  const auto recorded_environment = MakeSimulatedEnvironment(scene);
  SenseRecording recording(scene, {}, {.file = folder / "slave.mcap"});
  recording.Begin();
  EnvironmentPlayer player(*environment, scene);
  EnvironmentPlayer recorded_player(*recorded_environment, scene);
  RenderedForce simulated(MakeSensingPipeline(scene, {.player = &player}), scene);
  RenderedForce recorded(
      recording.Watch(MakeSensingPipeline(scene, {.tap = &recording, .player = &recorded_player})),
      scene);
  RenderedForce streamed(MakeSensingPipeline(streamed_scene), streamed_scene);
  recording.Opened();

  Eigen::Vector3d p_S_last = scene.manipulator.home;
  int images = 0;
  const Time start = Clock::now();
  while (images < kMaxImages && simulated.sense().Acquire({})) {
    ASSERT_TRUE(recorded.sense().Acquire({}));
    const Eigen::Vector3d p_S_tip = environment->truth().p_S_tip;
    const Eigen::Vector3d velocity =
        images == 0 ? Eigen::Vector3d::Zero().eval() : ((p_S_tip - p_S_last) / kImagePeriod).eval();
    simulated.Add(p_S_tip, velocity);
    const cv::Mat image = simulated.sense().Image(0)->plain;
    const std::string pixels(reinterpret_cast<const char*>(image.data),
                             image.total() * image.elemSize());
    PushedSample sample;
    sample.sensed_at = start + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(kImagePeriod * images));
    sample.image = {
        image.channels() == 3 ? PushedImage::Encoding::kBgr8 : PushedImage::Encoding::kGrey8,
        &pixels, static_cast<unsigned>(image.cols), static_cast<unsigned>(image.rows)};
    const auto refusal = streamed.sense().image_inbox()->Feed(sample, sample.sensed_at, 1);
    ASSERT_FALSE(refusal) << refusal->why;
    ASSERT_TRUE(streamed.sense().Acquire({}));
    recorded.Add(p_S_tip, velocity);
    streamed.Add(p_S_tip, velocity);
    p_S_last = p_S_tip;
    ++images;
  }
  const double peak = Peak(simulated.forces);
  ASSERT_GT(peak, 0.5) << images << " images";
  // Tolerance: 1 % of the largest force.
  EXPECT_LT(LargestDifference(recorded.forces, simulated.forces), 0.01 * peak);
  EXPECT_LT(LargestDifference(streamed.forces, simulated.forces), 0.01 * peak);
  RecordProperty("peak_N", std::to_string(peak));
  RecordProperty("recorded_N",
                 std::to_string(LargestDifference(recorded.forces, simulated.forces)));
  RecordProperty("streamed_N",
                 std::to_string(LargestDifference(streamed.forces, simulated.forces)));
}

}  // namespace
}  // namespace palpate
