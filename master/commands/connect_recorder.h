// `connect --record`: records a session from the first state to the last command.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "master/link/slave_link.h"
#include "master/recording/bulk_watch.h"
#include "master/recording/session_recording.h"
#include "master/session/session.h"
#include "master/station/moment_json.h"
#include "master/view/console.h"

namespace palpate {

// Must outlive the link.
class ConnectRecorder {
 public:
  // Adds its callbacks to `link`, so it must be made before the link. `part` [s]: length of a file;
  // 0: one file. Throws std::invalid_argument for an invalid limit, and std::runtime_error if the
  // file cannot be written.
  ConnectRecorder(const std::filesystem::path& file, const std::string& limit, double part,
                  SlaveLink::Options* link);

  // Starts after the connection: writes the session's settings, then images, shapes and status.
  void Begin(const SlaveLink::Options& link, McapMap session);
  // Adds itself to the callback of ticks.
  void AddOnlooker(Recorder::Onlooker* onlooker);
  // Switches the recording on or off. Thread-safe, like the functions below.
  void Switch(bool on) { recording_.Switch(on); }
  [[nodiscard]] RecordingMoment moment() const;  // reads the free disk space
  // Closes the file, prints its size and adds missing data to the report. False: it could not be
  // written.
  bool Finish(Console* console, Report* report);

 private:
  const std::filesystem::path file_;
  SessionRecording recording_;
  std::optional<BulkWatch> bulk_;
};

}  // namespace palpate
