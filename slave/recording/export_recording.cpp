#include "slave/recording/export_recording.h"

#include <spdlog/fmt/fmt.h>

#include "palpate/v1/recording.pb.h"

#include "foxglove/schemas.pb.h"
#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"
#include "slave/recording/scene_files.h"
#include "slave/recording/sense_recording.h"
#include "slave/recording/step_messages.h"

namespace palpate {
namespace {

std::filesystem::path Made(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  return folder;
}

class Export {
 public:
  Export(const std::filesystem::path& file, const std::filesystem::path& out)
      : reader_(file), out_(Made(out)) {}

  RecordingCounts Run(const std::stop_token& stop) {
    while (!stop.stop_requested() && reader_.Next()) {
      if (reader_.topic() == kStepTopic) {
        const auto step = Parsed<v1::SenseStep>();
        if (step.has_images()) sequence_ = step.images().sequence();
      } else if (reader_.topic() == kLeftTopic) {
        Keep("left");
      } else if (reader_.topic() == kRightTopic) {
        Keep("right");
      }
    }
    counts_.damage = reader_.damage();
    return counts_;
  }

 private:
  template <class Message>
  [[nodiscard]] Message Parsed() const {
    Message message;
    reader_.Read(&message);
    return message;
  }
  void Keep(const char* side) {
    const auto image = Parsed<foxglove::CompressedImage>();
    const auto folder = Made(out_ / side);
    WriteWholeFile(folder / fmt::format("{:06}.png", sequence_), image.data());
    ++counts_.pictures;
  }

  RecordingReader reader_;
  const std::filesystem::path out_;
  std::uint64_t sequence_ = 0;  // of the newest image
  RecordingCounts counts_;
};

}  // namespace

RecordingCounts ExportRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                                const std::stop_token& stop) {
  UnpackSceneFiles(RecordedBeginning(file).files, out / "scene");
  return Export(file, out).Run(stop);
}

}  // namespace palpate
