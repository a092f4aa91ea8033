// `palpate-master replay`: a recorded session on the operator's page.
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

// Shows the recording at `at` until `stop`. Returns 0. Throws InputError for a file that is damaged
// or no master's recording, std::invalid_argument if `from` is after its end, and
// std::runtime_error if the address cannot be used.
int RunReplay(const ReplayOptions& options, const PagePlace& at, const std::stop_token& stop);

}  // namespace palpate
