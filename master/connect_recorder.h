// `connect --record`: the session's recording, from the link's first state to its last words.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "master/haptics/session.h"
#include "master/link/slave_link.h"
#include "master/recording/bulk_watch.h"
#include "master/recording/session_recording.h"
#include "master/station/moment_json.h"
#include "master/view/console.h"

namespace palpate {

// Outlives the link.
class ConnectRecorder {
 public:
  // Looks on at what the link takes and sends from now on: before one is made of `link`. `part`
  // [s]: a new file after so long; 0: one file. Throws std::invalid_argument: not a limit;
  // std::runtime_error: the file cannot be written.
  ConnectRecorder(const std::filesystem::path& file, const std::string& limit, double part,
                  SlaveLink::Options* link);

  // The slave was reached: what the session goes by, and pictures, shape and health from now on.
  void Begin(const SlaveLink::Options& link, McapMap session);
  // Sees each tick, beside whoever does already.
  void AddOnlooker(Recorder::Onlooker* onlooker);
  // Goes on, or keeps nothing for a while. Thread-safe, as is what follows.
  void Switch(bool on) { recording_.Switch(on); }
  [[nodiscard]] RecordingMoment moment() const;  // asks the disk for its room
  // Closes the file, says how large it is, tells the report what is missing. False: it could not be
  // written.
  bool Finish(Console* console, Report* report);

 private:
  const std::filesystem::path file_;
  SessionRecording recording_;
  std::optional<BulkWatch> bulk_;
};

}  // namespace palpate
