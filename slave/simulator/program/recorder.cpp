#include "slave/simulator/program/recorder.h"

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>

#include <google/protobuf/util/delimited_message_util.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/wire/fields.h"
#include "slave/simulator/program/driver_messages.h"

namespace palpate {
namespace {

std::string CsvOf(const Eigen::Vector3d& v) {
  return fmt::format("{},{},{}", v.x(), v.y(), v.z());
}

// A file that is written, or an exception that names it.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path path)
      : path_(std::move(path)), stream_(path_, std::ios::binary) {
    Require(stream_.good());
  }
  void Add(const google::protobuf::MessageLite& message) {
    Require(google::protobuf::util::SerializeDelimitedToOstream(message, &stream_));
  }
  void Add(const std::string& line) { Require((stream_ << line << '\n').good()); }
  void Close() {
    stream_.close();
    Require(stream_.good());
  }

 private:
  void Require(bool is_written) const {
    if (!is_written) throw std::runtime_error(path_.string() + ": cannot be written");
  }
  std::filesystem::path path_;
  std::ofstream stream_;
};

// What a manipulator reports, and what only the simulator knows.
class TruthFiles {
 public:
  TruthFiles(const Scene& scene, const SimulatedEnvironment& environment,
             const std::filesystem::path& folder)
      : scene_(scene),
        environment_(environment),
        arm_(folder / "arm.pb"),
        truth_(folder / "truth.csv") {
    truth_.Add(
        "sample,t,finger,tip_x,tip_y,tip_z,force_x,force_y,force_z,depth,in_contact,solved,"
        "punctured");
  }
  void Add(std::uint64_t sample, Time sensed_at) {
    const Truth truth = environment_.truth();
    v1::ArmReport report;
    report.set_sequence(sample);
    ToProto(sensed_at, report.mutable_measured_at());
    ToProto(truth.p_S_tip, report.mutable_p_s_tip());
    if (truth.solved) ToProto(truth.force, report.mutable_measured_force());
    arm_.Add(report);
    const std::string instant = fmt::format("{},{}", sample, SecondsBetween(Time{}, sensed_at));
    const auto* tactile = scene_.sense.Find<Tactile>();
    if (tactile == nullptr) {
      truth_.Add(
          Row(instant, "", truth.p_S_tip, truth.force, truth.depth, truth.in_contact, truth));
      return;
    }
    for (std::size_t i = 0; i < tactile->fingers.size(); ++i) {
      const FingerTruth& finger = truth.fingers[i];
      truth_.Add(Row(instant, tactile->fingers[i].name, finger.X_SF.translation(), finger.force,
                     finger.depth, finger.in_contact, truth));
    }
  }
  void Close() {
    arm_.Close();
    truth_.Close();
  }

 private:
  static std::string Row(const std::string& instant, const std::string& finger,
                         const Eigen::Vector3d& p_S, const Eigen::Vector3d& force, double depth,
                         bool in_contact, const Truth& truth) {
    return fmt::format("{},{},{},{},{},{:d},{:d},{:d}", instant, finger, CsvOf(p_S), CsvOf(force),
                       depth, in_contact, truth.solved, truth.punctured);
  }

  const Scene& scene_;
  const SimulatedEnvironment& environment_;
  OutputFile arm_, truth_;
};

// `write` adds a sample to the file of samples.
template <typename Source, typename Write>
std::uint64_t RecordFrom(Source& source, const std::stop_token& stop, TruthFiles* truth,
                         const Write& write) {
  std::uint64_t count = 0;
  while (const auto sample = source.Next(stop)) {
    write(*sample);
    truth->Add(sample->sequence, sample->sensed_at);
    ++count;
  }
  return count;
}

}  // namespace

void Record(const Scene& scene, SimulatedEnvironment& environment,
            const std::filesystem::path& folder, double duration, const std::stop_token& stop) {
  std::filesystem::create_directories(folder);
  const Pace pace{.is_live = false, .duration = duration};
  const auto* tactile = scene.sense.Find<Tactile>();
  OutputFile samples(folder / (tactile != nullptr ? "tactile.pb" : "pictures.pb"));
  TruthFiles truth(scene, environment, folder);
  const auto picture = [&](const auto& sample) { samples.Add(ToMessage(sample)); };
  const auto touch = [&](const TactileFrame& frame) {
    for (const auto& message : ToMessages(frame, tactile->fingers)) samples.Add(message);
  };
  std::uint64_t count = 0;
  if (tactile != nullptr) {
    count = RecordFrom(*environment.OpenFingertips(scene, pace), stop, &truth, touch);
  } else if (HasStereoOrDepth(scene.sense)) {
    count = RecordFrom(*environment.OpenPair(scene, pace), stop, &truth, picture);
  } else {
    count = RecordFrom(*environment.OpenCamera(scene, pace), stop, &truth, picture);
  }
  samples.Close();
  truth.Close();
  spdlog::info("{} samples in {}", count, folder.string());
}

}  // namespace palpate
