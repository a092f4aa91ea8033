// `palpate-slave serve --record`: writes what the slave senses and logs to FILE.mcap.
#pragma once

#include <filesystem>
#include <memory>

#include <spdlog/sinks/sink.h>

#include "slave/commands/serve/serve.h"
#include "slave/recording/sense_recording.h"

namespace palpate {

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

}  // namespace palpate
