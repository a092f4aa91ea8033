// ForeignFormat recognises files that Palpate does not read by their first bytes, and says how to
// convert them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace palpate {

// Returns for example `a workbook (.xlsx): save the table as CSV` from the first 512 bytes. Empty:
// text, or unknown.
std::string ForeignFormat(std::string_view beginning);
// Applies ForeignFormat to the beginning of a file. Also returns an empty string if the file cannot
// be read.
std::string ForeignFile(const std::filesystem::path& file);

}  // namespace palpate
