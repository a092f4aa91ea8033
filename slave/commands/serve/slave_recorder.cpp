#include "slave/commands/serve/slave_recorder.h"

#include <algorithm>
#include <mutex>
#include <string>

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "shared/text/text.h"

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

}  // namespace

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

}  // namespace palpate
