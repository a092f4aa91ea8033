// Recordings (FILE.mcap) of `palpate-slave`: writes them and recomputes their states.
#pragma once

#include <memory>

#include <spdlog/sinks/sink.h>

#include "slave/commands/commands.h"
#include "slave/recording/sense_recording.h"

namespace palpate {

// By its name.
bool IsRecording(const std::filesystem::path& file);

// While a slave serves, its sensing and its log are written to the file. Ends with a line in the
// log.
class SlaveRecorder {
 public:
  // Throws std::invalid_argument or std::runtime_error: the options, the file cannot be written.
  SlaveRecorder(const ServeOptions& options, const Scene& scene);
  ~SlaveRecorder();
  SlaveRecorder(const SlaveRecorder&) = delete;
  SlaveRecorder& operator=(const SlaveRecorder&) = delete;

  [[nodiscard]] SenseRecorder& sense() { return recording_; }

 private:
  const std::filesystem::path file_;
  SenseRecording recording_;
  std::shared_ptr<spdlog::sinks::sink> sink_;
};

// Null: nothing is to be recorded.
std::unique_ptr<SlaveRecorder> OpenRecording(const ServeOptions& options, const Scene& scene);

// `palpate-slave process FILE.mcap`. 0: done, whatever differs. Throws InputError and
// std::exception.
int RunProcessRecording(const ProcessOptions& options, const std::stop_token& stop);

// `palpate-slave export FILE.mcap`.
struct RecordingExport {
  std::filesystem::path file, out;
};

// Runs ExportRecording. 0: done. Throws as RunProcessRecording.
int RunExportRecording(const RecordingExport& options, const std::stop_token& stop);

}  // namespace palpate
