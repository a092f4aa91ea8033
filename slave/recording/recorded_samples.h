// Replays the samples of a slave's recording to its sensing.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "palpate/v1/recording.pb.h"

#include "shared/recording/recording_reader.h"
#include "slave/capture/sample_tap.h"

namespace palpate {

class RecordedSamples final : public SamplePlayer {
 public:
  // Reads the last source that was opened before the sense acquired its first sample. Throws
  // InputError: not a recording.
  explicit RecordedSamples(const std::filesystem::path& file);

  std::unique_ptr<FrameSource> OpenFrames() override;
  std::unique_ptr<StereoSource> OpenPairs() override;
  std::unique_ptr<TactileSource> OpenFingertips() override;

  // Return the next sample of each kind; nullopt: there is no more. Throw InputError if the file is
  // damaged.
  std::optional<Frame> NextFrame();
  std::optional<StereoPair> NextPair();
  std::optional<TactileFrame> NextTactile();
  // Returns why there are no more samples although the recording continues; empty: it does not.
  [[nodiscard]] const std::string& gap() const { return gap_; }

 private:
  bool NextStep(v1::SenseStep* step);
  // The next image on `topic`, taken at `sensed_at`; empty: the recording ends, or it is missing.
  cv::Mat NextImage(std::string_view topic, Time sensed_at);
  // Reads the next images into `*pair`; false: there are none.
  bool NextImages(StereoPair* pair);

  RecordingReader reader_;
  std::string gap_;
};

}  // namespace palpate
