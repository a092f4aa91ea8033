// What a file is that Palpate does not read, by its first bytes, and how to convert it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace palpate {

// `a workbook (.xlsx): save the table as CSV`, by up to 512 bytes. Empty: text, or unknown.
std::string ForeignFormat(std::string_view beginning);
// The same for the beginning of a file. Empty also where it cannot be read.
std::string ForeignFile(const std::filesystem::path& file);

}  // namespace palpate
