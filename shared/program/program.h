// Version of the running program, location of its parts, and its standard output.
#pragma once

#include <filesystem>
#include <string_view>

namespace palpate {

// The version, such as 0.1.0+1a2b3c4d: release and git commit, if known. `.changed` follows if the
// sources had local changes.
const char* Version();

// Finds an optional program or module beside the running program or in ../lib/palpate. Empty: not
// found.
std::filesystem::path FindPart(std::string_view name);

// Returns whether the standard output could not be written because the disk is full. A terminal or
// a reader that went away is no failure.
bool OutputIsOnFullDisk();

}  // namespace palpate
