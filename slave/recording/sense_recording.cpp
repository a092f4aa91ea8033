#include "slave/recording/sense_recording.h"

#include <utility>

#include <spdlog/fmt/fmt.h>

#include "palpate/v1/recording.pb.h"

#include "foxglove/schemas.pb.h"
#include "shared/program/program.h"
#include "shared/wire/fields.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/recording/scene_files.h"
#include "slave/recording/step_messages.h"

namespace palpate {
namespace {

std::string ImageMessage(const cv::Mat& image, Time sensed_at) {
  foxglove::CompressedImage message;
  ToProto(sensed_at, message.mutable_timestamp());
  message.set_format("png");
  message.set_frame_id("camera");
  message.set_data(EncodePng(image));
  return message.SerializeAsString();
}

std::string Joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

}  // namespace

// Records each call that changes the sensing before the call is made, so that its effects follow it
// in the recording.
class SenseRecording::WatchedSense final : public SensingPipeline {
 public:
  WatchedSense(SenseRecording* kept, std::unique_ptr<SensingPipeline> sense)
      : kept_(*kept), sense_(std::move(sense)) {}

  bool Acquire(const std::stop_token& stop) override {
    const bool acquired = sense_->Acquire(stop);
    if (acquired) Put([](v1::SenseStep* step) { step->mutable_acquired(); });
    return acquired;
  }
  void Process() noexcept override { sense_->Process(); }
  const ContactEstimate& Estimate(const TipReading& encoders) noexcept override {
    const ContactEstimate& estimate = sense_->Estimate(encoders);
    Put([&](v1::SenseStep* step) {
      ToProto(encoders.p_S_tip, step->mutable_estimate()->mutable_p_s_arm());
      if (encoders.frame) step->mutable_estimate()->set_arm_frame(*encoders.frame);
      ToProto(estimate, step->mutable_estimate());
    });
    PutTip(estimate);
    return estimate;
  }
  [[nodiscard]] std::string_view flag_reason() const override { return sense_->flag_reason(); }
  LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept override {
    Put([&](v1::SenseStep* step) { ToProto(p_S_tip, step->mutable_plane_at()); });
    return sense_->LocalModelAt(p_S_tip);
  }
  bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept override {
    Put([&](v1::SenseStep* step) { ToProto(p_S_tip, step->mutable_patch_at()); });
    return sense_->MakePatch(p_S_tip, patch);
  }
  [[nodiscard]] bool HasOutgrownPatch() const noexcept override {
    return sense_->HasOutgrownPatch();
  }
  [[nodiscard]] SurfaceMotion motion() const noexcept override { return sense_->motion(); }
  void LearnLaw(PatchLaw* law) noexcept override {
    Put([](v1::SenseStep* step) { step->mutable_law(); });
    sense_->LearnLaw(law);
  }
  // A field changes no internal state, so that it is not recorded.
  BoundaryShape Shape(const ShapeParts& parts) override {
    Put([&](v1::SenseStep* step) { step->set_shape(parts.nodal_forces); });
    return sense_->Shape(parts);
  }
  [[nodiscard]] std::optional<OverlaidImage> Image(double full_scale) const override {
    return sense_->Image(full_scale);
  }
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                       Progress* progress) const override {
    return sense_->Prepare(changed, progress);
  }
  void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) override {
    Put([&](v1::SenseStep* step) { ToProto(changed, step->mutable_settings()); });
    sense_->Adopt(std::move(prepared), changed);
  }
  void Reset(const std::function<bool()>& is_disengaged) override {
    Put([](v1::SenseStep* step) { step->mutable_reset(); });
    sense_->Reset([this, is_disengaged] {
      const bool goes_on = is_disengaged();
      if (!goes_on) Put([](v1::SenseStep* step) { step->mutable_engaged(); });
      return goes_on;
    });
  }
  [[nodiscard]] SenseInfo info() const override { return sense_->info(); }
  [[nodiscard]] std::vector<StageTimes> Stages() const override { return sense_->Stages(); }
  std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth* truth) override {
    return sense_->OpenOfflineReport(truth);
  }
  [[nodiscard]] TactileInbox* inbox() override { return sense_->inbox(); }
  [[nodiscard]] ImageInbox* image_inbox() override { return sense_->image_inbox(); }
  [[nodiscard]] Time sensed_at() const override { return sense_->sensed_at(); }
  [[nodiscard]] std::optional<CameraHealth> health() const override { return sense_->health(); }

 private:
  template <typename Fill>
  void Put(const Fill& fill) {
    v1::SenseStep step;
    fill(&step);
    kept_.recording_->Put(kept_.steps_, Clock::now(), step);
  }
  void PutTip(const ContactEstimate& estimate) {
    foxglove::PoseInFrame pose;
    ToProto(estimate.sensed_at, pose.mutable_timestamp());
    pose.set_frame_id("slave");
    auto* position = pose.mutable_pose()->mutable_position();
    position->set_x(estimate.p_S_tip.x());
    position->set_y(estimate.p_S_tip.y());
    position->set_z(estimate.p_S_tip.z());
    pose.mutable_pose()->mutable_orientation()->set_w(1);
    kept_.recording_->Put(kept_.tip_, Clock::now(), pose);
  }

  SenseRecording& kept_;
  const std::unique_ptr<SensingPipeline> sense_;
};

SenseRecording::SenseRecording(const Scene& scene, const std::vector<std::string>& overrides,
                               Recording::Options options)
    : overrides_(Joined(overrides)) {
  options.library = std::string("palpate-slave ") + Version();
  recording_ = std::make_unique<Recording>(std::move(options));
  const SceneFiles files = GatherSceneFiles(scene);
  scene_file_ = files.scene;
  left_out_ = files.left_out;
  for (const auto& [name, bytes] : files.bytes) recording_->Attach(name, bytes);
  steps_ = recording_->Open(kStepTopic, v1::SenseStep());
  left_ = recording_->Open(kLeftTopic, foxglove::CompressedImage());
  right_ = recording_->Open(kRightTopic, foxglove::CompressedImage());
  tip_ = recording_->Open(kTipTopic, foxglove::PoseInFrame());
  log_ = recording_->Open(kLogTopic, foxglove::Log());
}

SenseRecording::~SenseRecording() = default;

void SenseRecording::Begin() {
  recording_->Note(kSenseNote, {{"version", Version()},
                                {"scene", scene_file_},
                                {"overrides", overrides_},
                                {"left_out", Joined(left_out_)}});
  has_begun_ = true;
}

std::unique_ptr<SensingPipeline> SenseRecording::Watch(std::unique_ptr<SensingPipeline> sense) {
  return std::make_unique<WatchedSense>(this, std::move(sense));
}

void SenseRecording::Opened() {
  v1::SenseStep step;
  step.mutable_opened();
  recording_->Put(steps_, Clock::now(), step);
}

void SenseRecording::PutInstant(std::uint64_t sequence, Time sensed_at, int images, double skew) {
  v1::SenseStep step;
  step.mutable_images()->set_sequence(sequence);
  ToProto(sensed_at, step.mutable_images()->mutable_sensed_at());
  step.mutable_images()->set_images(static_cast<std::uint32_t>(images));
  step.mutable_images()->set_skew(skew);
  recording_->Put(steps_, Clock::now(), step);
}

// The writing thread compresses the images, which takes milliseconds. Returned images are never
// changed.
void SenseRecording::PutImage(std::uint16_t channel, const cv::Mat& image, Time sensed_at) {
  recording_->Put(channel, Clock::now(), image.total() * image.elemSize(),
                  [image, sensed_at] { return ImageMessage(image, sensed_at); });
}

void SenseRecording::OnSample(const Frame& frame) {
  PutInstant(frame.sequence, frame.sensed_at, 1, 0);
  PutImage(left_, frame.image, frame.sensed_at);
}

void SenseRecording::OnSample(const StereoPair& pair) {
  PutInstant(pair.sequence, pair.sensed_at, pair.right.empty() ? 1 : 2, pair.skew);
  PutImage(left_, pair.left, pair.sensed_at);
  if (!pair.right.empty()) PutImage(right_, pair.right, pair.sensed_at);
}

void SenseRecording::OnSample(const TactileFrame& frame) {
  v1::SenseStep step;
  ToProto(frame, step.mutable_tactile());
  recording_->Put(steps_, Clock::now(), step);
}

void SenseRecording::Log(int level, const std::string& line) {
  if (!has_begun_) return;
  foxglove::Log log;
  const Time now = Clock::now();
  ToProto(now, log.mutable_timestamp());
  log.set_level(static_cast<foxglove::Log::Level>(level + 1));
  log.set_message(line);
  log.set_name("palpate-slave");
  recording_->Put(log_, now, log);
}

}  // namespace palpate
