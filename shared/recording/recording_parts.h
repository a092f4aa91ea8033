// Parts of a recording: `session-0001.mcap`, `session-0002.mcap`, ... of `session.mcap`. Each is a
// recording by itself, and together they are one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/recording/mcap_bytes.h"

namespace palpate {

// Name of the metadata that identifies the recording of a part.
inline constexpr const char* kPartNote = "palpate.part";

// The file of part `number` (from 1) of the recording `file`. Names sort correctly up to 9999.
std::filesystem::path PartFile(const std::filesystem::path& file, int number);

// `identity`: common to all parts of a recording, and unique.
McapMap PartNote(const std::string& identity, int number);

// The files of the recording `file`, in order. Returns `file` itself if it exists or has no parts.
std::vector<std::filesystem::path> PartsOf(const std::filesystem::path& file);

}  // namespace palpate
