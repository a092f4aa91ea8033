// `palpate-slave identify`: material constants from tables of tests.
#pragma once

#include <filesystem>
#include <stop_token>

#include "slave/identify/identify_material.h"

namespace palpate {

struct IdentifyOptions : IdentifyRequest {
  std::filesystem::path out;  // folder, created if missing
};

extern const char* const kIdentifyHelp;  // text of --help below the options

// Writes report.json into `out` and prints the results. 0: done. Throws InputError, SceneError,
// std::invalid_argument, exceptions of writing, and Interrupted.
int RunIdentify(const IdentifyOptions& options, const std::stop_token& stop);

}  // namespace palpate
