// Commands of palpate-master for recordings.
#pragma once

#include <filesystem>
#include <stop_token>

#include "master/station/server/page_access.h"

namespace palpate {

struct ReplayOptions {
  std::filesystem::path file;
  double speed = 1;  // Replay::kSlowest to kFastest
  double from = 0;   // [s] after its start
};

// Shows the recording in the terminal, with the badge REPLAY. Returns 0. Throws InputError for a
// file that is damaged or no master's recording, and std::invalid_argument if `from` is after its
// end.
int RunReplay(const ReplayOptions& options, const std::stop_token& stop);

// Shows the recording on the operator's page at `at`, until `stop`. Returns 0. Throws like
// RunReplay, and std::runtime_error if the address cannot be used.
int ViewReplay(const ReplayOptions& options, const PagePlace& at, const std::stop_token& stop);

struct SessionExportOptions {
  std::filesystem::path file, out;
};

// Exports the recording into the folder `out`, see ExportSession. Returns 0. Throws like RunReplay,
// and std::runtime_error if it cannot write.
int RunExport(const SessionExportOptions& options, const std::stop_token& stop);

}  // namespace palpate
