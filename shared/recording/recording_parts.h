// A recording in parts: `session-0001.mcap`, `session-0002.mcap`, ..., by the name `session.mcap`.
// Each is a recording by itself; together they are one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/recording/mcap_bytes.h"

namespace palpate {

// Of the note that says which recording a part is of.
inline constexpr const char* kPartNote = "palpate.part";

// Where part `number` (from 1) of the recording `file` is. They sort by name up to the 9999th.
std::filesystem::path PartFile(const std::filesystem::path& file, int number);

// `identity`: the same in all parts of a recording, in no other.
McapMap PartNote(const std::string& identity, int number);

// The files that hold the recording `file`, in order: itself, where there is such a file or no part
// of it.
std::vector<std::filesystem::path> PartsOf(const std::filesystem::path& file);

}  // namespace palpate
