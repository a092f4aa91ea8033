#include "slave/commands/record/record.h"

#include <array>
#include <mutex>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "shared/text/text.h"
#include "slave/recording/export_recording.h"
#include "slave/recording/recorded_run.h"

namespace palpate {
namespace {

// Every line of the log goes to the recording, too.
class RecordingSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit RecordingSink(SenseRecording* recording) : recording_(*recording) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& line) override {
    constexpr int kDebug = static_cast<int>(spdlog::level::debug);
    recording_.Log(std::max(0, static_cast<int>(line.level) - kDebug),
                   {line.payload.data(), line.payload.size()});
  }
  void flush_() override {}

 private:
  SenseRecording& recording_;
};

Recording::Options FileOptions(const ServeOptions& options, const Scene& scene) {
  RequireOtherThan("--record", options.record, InputFilesOf(scene));
  Recording::Options file;
  file.file = options.record;
  file.limit = ParseRecordLimit(options.record_limit);
  file.part = options.record_part;
  file.tell = [](const std::string& why) { spdlog::warn("{}", why); };
  return file;
}

void RefuseOptions(const ProcessOptions& options) {
  if (options.overrides.empty() && !options.pictures && !options.frames && !options.points &&
      !options.duration) {
    return;
  }
  throw std::invalid_argument(options.scene.string() +
                              ": accepted with a recording is --out only: a recording contains its "
                              "scene, and no images are drawn");
}

// A recording that cannot be used is an unusable argument.
template <class Read>
auto Reading(const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
}

}  // namespace

bool IsRecording(const std::filesystem::path& file) {
  return file.extension() == ".mcap";
}

SlaveRecorder::SlaveRecorder(const ServeOptions& options, const Scene& scene)
    : file_(options.record),
      recording_(scene, options.overrides, FileOptions(options, scene)),
      sink_(std::make_shared<RecordingSink>(&recording_)) {
  spdlog::default_logger()->sinks().push_back(sink_);
  spdlog::info("recording to {}, size limit {}", file_.string(), options.record_limit);
}

SlaveRecorder::~SlaveRecorder() {
  std::erase(spdlog::default_logger()->sinks(), sink_);
  recording_.Finish();
  const Recording::Stats stats = recording_.stats();
  spdlog::info("recorded {:.1f} MB in {} messages to {}", 1e-6 * static_cast<double>(stats.bytes),
               stats.messages, file_.string());
  if (!stats.trouble.empty()) spdlog::warn("{}", stats.trouble);
}

std::unique_ptr<SlaveRecorder> OpenRecording(const ServeOptions& options, const Scene& scene) {
  if (options.record.empty()) return nullptr;
  return std::make_unique<SlaveRecorder>(options, scene);
}

int RunProcessRecording(const ProcessOptions& options, const std::stop_token& stop) {
  RefuseOptions(options);
  const std::array inputs{options.scene};
  RequireOtherThan("--out", options.out, {"states.csv", "summary.json"}, inputs);
  const RecordedRun run =
      Reading([&] { return ProcessRecording(options.scene, options.out, stop); });
  for (const std::string& line : InWords(run)) fmt::print("{}\n", line);
  return 0;
}

int RunExportRecording(const RecordingExport& options, const std::stop_token& stop) {
  const RecordingCounts counts =
      Reading([&] { return ExportRecording(options.file, options.out, stop); });
  fmt::print("{} states, {} images, {} tactile samples\n", counts.states, counts.pictures,
             counts.tactile);
  if (!counts.damage.empty()) fmt::print("incomplete: {}\n", counts.damage);
  fmt::print("written: {}\n", options.out.string());
  return 0;
}

}  // namespace palpate
