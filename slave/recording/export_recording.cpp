#include "slave/recording/export_recording.h"

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "palpate/v1/recording.pb.h"

#include "foxglove/schemas.pb.h"
#include "shared/recording/npy.h"
#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"
#include "slave/recording/scene_files.h"
#include "slave/recording/sense_recording.h"
#include "slave/recording/step_messages.h"

namespace palpate {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::filesystem::path Made(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  return folder;
}

std::array<double, 3> Row(const v1::Exact3& v) {
  return {v.x(), v.y(), v.z()};
}

class StateArrays {
 public:
  explicit StateArrays(const std::filesystem::path& folder)
      : t_(NpyFile::Of<double>(folder / "t.npy", 1)),
        sample_(NpyFile::Of<std::uint64_t>(folder / "sample.npy", 1)),
        tip_(NpyFile::Of<double>(folder / "p_S_tip.npy", 3)),
        force_(NpyFile::Of<double>(folder / "force.npy", 3)),
        sigma_(NpyFile::Of<double>(folder / "sigma.npy", 1)),
        moment_(NpyFile::Of<double>(folder / "moment.npy", 3)),
        moment_sigma_(NpyFile::Of<double>(folder / "moment_sigma.npy", 1)),
        validity_(NpyFile::Of<std::uint8_t>(folder / "validity.npy", 1)),
        check_(NpyFile::Of<std::uint8_t>(folder / "check.npy", 1)) {}

  void Add(double t, const v1::FeltState& felt) {
    t_.Add(t);
    sample_.Add(std::uint64_t{felt.sample()});
    tip_.Add(std::span<const double>(Row(felt.p_s_tip())));
    const std::array unknown{kUnknown, kUnknown, kUnknown};
    const bool known = felt.has_force();
    force_.Add(std::span<const double>(known ? Row(felt.force()) : unknown));
    sigma_.Add(known ? felt.sigma() : kUnknown);
    const bool has_moment = felt.has_moment();
    moment_.Add(std::span<const double>(has_moment ? Row(felt.moment()) : unknown));
    moment_sigma_.Add(has_moment ? felt.moment_sigma() : kUnknown);
    validity_.Add(static_cast<std::uint8_t>(felt.validity()));
    check_.Add(static_cast<std::uint8_t>(felt.check()));
  }
  void Finish() {
    for (NpyFile* file :
         {&t_, &sample_, &tip_, &force_, &sigma_, &moment_, &moment_sigma_, &validity_, &check_}) {
      file->Finish();
    }
  }

 private:
  NpyFile t_, sample_, tip_, force_, sigma_, moment_, moment_sigma_, validity_, check_;
};

// As many columns as the first sample has fingertips.
class TactileArray {
 public:
  explicit TactileArray(std::filesystem::path file) : file_(std::move(file)) {}

  void Add(double t, const TactileFrame& frame, std::size_t fingers) {
    const std::size_t columns = 1 + fingers * (kElectrodeCount + 2);
    if (!array_) array_.emplace(NpyFile::Of<double>(file_, static_cast<int>(columns)));
    std::vector<double> row{t};
    for (std::size_t i = 0; i < fingers; ++i) {
      const FingerReading& reading = frame.fingers[i];
      for (const float x : reading.electrodes) row.push_back(reading.present ? x : kUnknown);
      row.push_back(reading.present ? reading.pac : kUnknown);
      row.push_back(reading.present ? reading.pdc : kUnknown);
    }
    array_->Add(std::span<const double>(row));
  }
  void Finish() {
    if (array_) array_->Finish();
  }

 private:
  std::filesystem::path file_;
  std::optional<NpyFile> array_;
};

class Export {
 public:
  Export(const std::filesystem::path& file, const std::filesystem::path& out)
      : reader_(file),
        out_(Made(out)),
        states_(Made(out_ / "numpy")),
        tactile_(out_ / "numpy" / "tactile.npy") {}

  RecordingCounts Run(const std::stop_token& stop) {
    while (!stop.stop_requested() && reader_.Next()) {
      if (reader_.topic() == kStepTopic) {
        Take(Parsed<v1::SenseStep>());
      } else if (reader_.topic() == kLeftTopic) {
        Keep("left");
      } else if (reader_.topic() == kRightTopic) {
        Keep("right");
      }
    }
    states_.Finish();
    tactile_.Finish();
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
  double SecondsAt(std::uint64_t ns) {
    const Time at = StampFrom(ns);
    if (!first_) first_ = at;
    return SecondsBetween(*first_, at);
  }
  void Take(const v1::SenseStep& step) {
    if (step.has_pictures()) {
      SecondsAt(step.pictures().sensed_at_ns());
      sequence_ = step.pictures().sequence();
    } else if (step.has_tactile()) {
      ++counts_.tactile;
      const TactileFrame frame = FromProto(step.tactile());
      if (fingers_ == 0) fingers_ = CountPresent(frame);
      tactile_.Add(SecondsAt(step.tactile().sensed_at_ns()), frame, fingers_);
    } else if (step.has_estimate()) {
      ++counts_.states;
      const v1::FeltState& felt = step.estimate().felt();
      states_.Add(SecondsAt(felt.sensed_at_ns()), felt);
    }
  }
  // Up to the last one that has a sample.
  static std::size_t CountPresent(const TactileFrame& frame) {
    std::size_t count = 1;
    for (std::size_t i = 0; i < frame.fingers.size(); ++i) {
      if (frame.fingers[i].present) count = i + 1;
    }
    return count;
  }
  void Keep(const char* side) {
    const auto image = Parsed<foxglove::CompressedImage>();
    const auto folder = Made(out_ / side);
    WriteWholeFile(folder / fmt::format("{:06}.png", sequence_), image.data());
    ++counts_.pictures;
  }

  RecordingReader reader_;
  const std::filesystem::path out_;
  StateArrays states_;
  TactileArray tactile_;
  std::optional<Time> first_;
  std::uint64_t sequence_ = 0;
  std::size_t fingers_ = 0;
  RecordingCounts counts_;
};

}  // namespace

RecordingCounts ExportRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                                const std::stop_token& stop) {
  UnpackSceneFiles(RecordedBeginning(file).files, out / "scene");
  return Export(file, out).Run(stop);
}

}  // namespace palpate
