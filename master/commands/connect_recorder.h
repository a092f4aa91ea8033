// `connect --record`: records a session from the first state to the last command.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "master/link/observer.h"
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

  // Starts after the connection to `target`: writes the session's settings.
  void Begin(const std::string& target, McapMap session);
  // The file that is written, see UnusedFile.
  [[nodiscard]] const std::filesystem::path& file() const { return recording_.file(); }
  // Records images, shapes, traces and status that the observer hands on. Must outlive it.
  [[nodiscard]] std::function<void(const google::protobuf::Message&)> on_message() {
    return [this](const auto& message) { recording_.OnObserved(message); };
  }
  // Adds itself to the callback of ticks.
  void AddTickObserver(Recorder::TickObserver* observer);
  // Switches the recording on or off. Thread-safe, like the functions below.
  void Switch(bool on) { recording_.Switch(on); }
  [[nodiscard]] RecordingMoment moment() const;  // reads the free disk space
  // Closes the file, prints its size and adds missing data to the report. False: it could not be
  // written.
  bool Finish(Console* console, Report* report);

 private:
  SessionRecording recording_;
};

}  // namespace palpate
