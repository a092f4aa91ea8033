// Exports images and scene files of a slave's recording. deploy/python reads the rest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace palpate {

struct RecordingCounts {
  std::uint64_t pictures = 0;
  std::string damage;  // unreadable parts of the recording, as text; empty: none
};

// Writes into `out`, created if missing:
//
//   left/, right/   NNNNNN.png: the images, by their number
//   scene/          the scene's files
//
// Throws InputError: not a slave's recording, or damaged; std::runtime_error: not writable.
RecordingCounts ExportRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                                const std::stop_token& stop);

}  // namespace palpate
