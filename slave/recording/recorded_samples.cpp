#include "slave/recording/recorded_samples.h"

#include "foxglove/schemas.pb.h"
#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/recording/sense_recording.h"
#include "slave/recording/step_messages.h"

namespace palpate {
namespace {

// Returns how many sources were opened before the first sample was acquired.
int CountOpened(const std::filesystem::path& file) {
  RecordingReader reader(file);
  v1::SenseStep step;
  int opened = 0;
  while (reader.Next()) {
    if (reader.topic() != kStepTopic) continue;
    reader.Read(&step);
    if (step.has_acquired()) break;
    if (step.has_opened()) ++opened;
  }
  return opened;
}

cv::Mat Decoded(const std::string& png) {
  const auto image = OpenPng({reinterpret_cast<const unsigned char*>(png.data()), png.size()});
  if (!image || long{image->size().width} * image->size().height > kMaxPixels) {
    throw InputError("a recorded image: expected a PNG of at most " +
                     std::to_string(kMaxPixels / 1'000'000) + " megapixels");
  }
  return image->Decode();
}

template <typename Source, typename Sample>
class PlayedSource final : public Source {
 public:
  using Take = std::optional<Sample> (RecordedSamples::*)();

  PlayedSource(RecordedSamples* samples, Take take) : samples_(*samples), take_(take) {}
  std::optional<Sample> Next(const std::stop_token& stop) override {
    if (stop.stop_requested()) return std::nullopt;
    return (samples_.*take_)();
  }
  [[nodiscard]] std::string description() const override { return "a recording by a slave"; }

 private:
  RecordedSamples& samples_;
  Take take_;
};

}  // namespace

RecordedSamples::RecordedSamples(const std::filesystem::path& file) : reader_(file) {
  v1::SenseStep step;
  for (int left = CountOpened(file); left > 0 && NextStep(&step);) {
    if (step.has_opened()) --left;
  }
}

bool RecordedSamples::NextStep(v1::SenseStep* step) {
  while (reader_.Next()) {
    if (reader_.topic() != kStepTopic) continue;
    reader_.Read(step);
    return true;
  }
  return false;
}

cv::Mat RecordedSamples::NextImage(std::string_view topic, Time sensed_at) {
  foxglove::CompressedImage message;
  while (reader_.Next()) {
    if (reader_.topic() != topic) continue;
    reader_.Read(&message);
    google::protobuf::Timestamp expected;
    ToProto(sensed_at, &expected);
    if (message.timestamp().seconds() != expected.seconds() ||
        message.timestamp().nanos() != expected.nanos()) {
      gap_ =
          "an image is missing, because more arrived than could be written: the estimates from "
          "here on cannot be recomputed";
      return {};
    }
    return Decoded(message.data());
  }
  return {};
}

bool RecordedSamples::NextImages(StereoPair* pair) {
  v1::SenseStep step;
  do {
    if (!NextStep(&step)) return false;
  } while (!step.has_images());
  pair->sequence = step.images().sequence();
  pair->sensed_at = RecordedTime(step.images().sensed_at());
  pair->skew = step.images().skew();
  pair->left = NextImage(kLeftTopic, pair->sensed_at);
  if (step.images().images() > 1) pair->right = NextImage(kRightTopic, pair->sensed_at);
  return !pair->left.empty() && (step.images().images() < 2 || !pair->right.empty());
}

std::optional<Frame> RecordedSamples::NextFrame() {
  StereoPair pair;
  if (!NextImages(&pair)) return std::nullopt;
  return Frame{pair.left, pair.sequence, pair.sensed_at};
}

std::optional<StereoPair> RecordedSamples::NextPair() {
  StereoPair pair;
  return NextImages(&pair) ? std::optional(pair) : std::nullopt;
}

std::optional<TactileFrame> RecordedSamples::NextTactile() {
  v1::SenseStep step;
  do {
    if (!NextStep(&step)) return std::nullopt;
  } while (!step.has_tactile());
  return FromProto(step.tactile());
}

std::unique_ptr<FrameSource> RecordedSamples::OpenFrames() {
  return std::make_unique<PlayedSource<FrameSource, Frame>>(this, &RecordedSamples::NextFrame);
}

std::unique_ptr<StereoSource> RecordedSamples::OpenPairs() {
  return std::make_unique<PlayedSource<StereoSource, StereoPair>>(this, &RecordedSamples::NextPair);
}

std::unique_ptr<TactileSource> RecordedSamples::OpenFingertips() {
  return std::make_unique<PlayedSource<TactileSource, TactileFrame>>(this,
                                                                     &RecordedSamples::NextTactile);
}

}  // namespace palpate
