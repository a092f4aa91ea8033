// palpate-master's commands on recordings.
#pragma once

#include <filesystem>
#include <stop_token>

#include "master/station/server/page_access.h"

namespace palpate {

struct ReplayOptions {
  std::filesystem::path file;
  double speed = 1;  // Replay::kSlowest to kFastest
  double from = 0;   // [s] after its beginning
};

// Shows the recording in the terminal as `connect` shows a session, with a badge. 0: done. Throws
// InputError: not a master's recording, damaged; std::invalid_argument: `from` is after its end.
int RunReplay(const ReplayOptions& options, const std::stop_token& stop);

// Shows it on the operator's page `at` there, until `stop`. 0: done. Throws as RunReplay, and
// std::runtime_error: it cannot be listened there.
int ViewReplay(const ReplayOptions& options, const PagePlace& at, const std::stop_token& stop);

struct SessionExportOptions {
  std::filesystem::path file, out;
};

// Writes the recording for other tools into the folder `out`, see ExportSession. 0: done. Throws as
// RunReplay, and std::runtime_error: not writable.
int RunExport(const SessionExportOptions& options, const std::stop_token& stop);

}  // namespace palpate
