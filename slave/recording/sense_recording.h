// A slave's recording: each sample without loss, all queries to the sensing in order, and its
// estimates; also the scene's files and the log.
//
//   /slave/sense           palpate.v1.SenseStep: see there
//   /slave/left, /right    foxglove.CompressedImage, PNG: an image, or both of a pair
//   /slave/tip             foxglove.PoseInFrame: the measured tool tip
//   /log                   foxglove.Log
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/recording/recording.h"
#include "slave/pipeline/base/sense_recorder.h"
#include "slave/scene/scene.h"

namespace palpate {

inline constexpr std::string_view kStepTopic = "/slave/sense", kLeftTopic = "/slave/left",
                                  kRightTopic = "/slave/right", kTipTopic = "/slave/tip",
                                  kLogTopic = "/log";
// Fields of the note that describes how the sensing was created.
inline constexpr const char* kSenseNote = "palpate.sense";

class SenseRecording final : public SenseRecorder {
 public:
  // Throws std::runtime_error: the file cannot be written.
  SenseRecording(const Scene& scene, const std::vector<std::string>& overrides,
                 Recording::Options options);
  ~SenseRecording() override;

  void Begin() override;
  [[nodiscard]] std::string trouble() const override { return recording_->stats().trouble; }
  std::unique_ptr<SensingPipeline> Watch(std::unique_ptr<SensingPipeline> sense) override;

  void Opened() override;
  void OnSample(const Frame& frame) override;
  void OnSample(const StereoPair& pair) override;
  void OnSample(const TactileFrame& frame) override;

  // Lines of the log: 0 debug to 4 fatal. Lines before Begin are not recorded.
  void Log(int level, const std::string& line);
  // Everything is written, the file closed.
  void Finish() { recording_->Finish(); }
  [[nodiscard]] Recording::Stats stats() const { return recording_->stats(); }
  // The file that is written, see UnusedFile.
  [[nodiscard]] const std::filesystem::path& file() const { return recording_->file(); }

 private:
  class WatchedSense;
  void PutImage(std::uint16_t channel, const cv::Mat& image, Time sensed_at);
  void PutInstant(std::uint64_t sequence, Time sensed_at, int images, double skew);

  std::vector<std::string> left_out_;  // files of the scene that are too large to record
  std::string overrides_;              // one line each
  std::string scene_file_;             // name of the scene among the attached files
  std::unique_ptr<Recording> recording_;
  std::atomic<bool> has_begun_{false};  // the beginning of the recording is written
  std::uint16_t steps_, left_, right_, tip_, log_;
};

}  // namespace palpate
