#include "slave/simulator/program/recorder.h"

#include <cstdint>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include <google/protobuf/util/delimited_message_util.h>
#include <spdlog/spdlog.h>

#include "palpate/v1/simulation.pb.h"

#include "slave/simulator/program/driver_messages.h"

namespace palpate {
namespace {

// The file of samples; throws an exception that names it.
class SamplesFile {
 public:
  explicit SamplesFile(const std::filesystem::path& folder) {
    if (folder == "-") return;
    std::filesystem::create_directories(folder);
    path_ = folder / "samples.pb";
    file_.open(path_, std::ios::binary);
    Require(file_.good());
  }
  void Add(const v1::SimulatedSample& sample) {
    Require(google::protobuf::util::SerializeDelimitedToOstream(sample, &stream()));
  }
  void Close() { Require(stream().flush().good()); }
  [[nodiscard]] std::string name() const { return path_.empty() ? "standard output" : path_; }

 private:
  std::ostream& stream() { return path_.empty() ? std::cout : file_; }
  void Require(bool is_written) const {
    if (!is_written) throw std::runtime_error(name() + ": cannot be written");
  }

  std::filesystem::path path_;
  std::ofstream file_;
};

// `fill` puts a sample of `source` into a message.
template <typename Source, typename Fill>
std::uint64_t RecordFrom(Source& source, const SimulatedEnvironment& environment,
                         const Scene& scene, const std::stop_token& stop, SamplesFile* file,
                         const Fill& fill) {
  std::uint64_t count = 0;
  v1::SimulatedSample message;
  while (const auto sample = source.Next(stop)) {
    message.Clear();
    fill(*sample, &message);
    PutTruth(environment, scene, message.mutable_truth());
    file->Add(message);
    ++count;
  }
  return count;
}

}  // namespace

void Record(const Scene& scene, SimulatedEnvironment& environment, const RecordOptions& options,
            const std::stop_token& stop) {
  if (options.duration > 0 && !environment.target()) {
    throw std::invalid_argument(
        "--duration: only for a simulated target that moves on a path; the scripted contacts "
        "of " +
        scene.file.string() + " end on their own");
  }
  const ScriptedRun run{.duration = options.duration, .presses = options.presses};
  const auto* tactile = scene.sense.Find<Tactile>();
  SamplesFile file(options.folder);
  const auto image = [](const auto& sample, v1::SimulatedSample* message) {
    *message->mutable_images() = ToMessage(sample);
  };
  const auto touch = [&](const TactileFrame& frame, v1::SimulatedSample* message) {
    if (options.surface) {
      PutSurface(environment.TrueSurface(), frame.sequence == 1, message->mutable_truth());
    }
    for (auto& one : ToMessages(frame, tactile->fingers)) {
      *message->add_fingertips() = std::move(one);
    }
  };
  std::uint64_t count = 0;
  if (tactile != nullptr) {
    const auto source = environment.OpenFingertips(scene, run);
    count = RecordFrom(*source, environment, scene, stop, &file, touch);
  } else if (HasStereoOrDepth(scene.sense)) {
    const auto source = environment.OpenPair(scene, run);
    count = RecordFrom(*source, environment, scene, stop, &file, image);
  } else {
    const auto source = environment.OpenCamera(scene, run);
    count = RecordFrom(*source, environment, scene, stop, &file, image);
  }
  file.Close();
  spdlog::info("{} samples in {}", count, file.name());
}

}  // namespace palpate
