#include "shared/recording/recording_parts.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <system_error>

#include "shared/text/text.h"

namespace palpate {

std::filesystem::path PartFile(const std::filesystem::path& file, int number) {
  return file.parent_path() /
         (file.stem().string() + Formatted("-%04d", number) + file.extension().string());
}

McapMap PartNote(const std::string& identity, int number) {
  return {{"recording", identity}, {"number", std::to_string(number)}};
}

std::vector<std::filesystem::path> PartsOf(const std::filesystem::path& file) {
  constexpr std::size_t kLeastDigits = 4, kMostDigits = 9;
  std::error_code none;
  if (std::filesystem::exists(file, none)) return {file};
  const std::string begin = file.stem().string() + "-", end = file.extension().string();
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  std::map<int, std::filesystem::path> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (name.size() < begin.size() + end.size() + kLeastDigits || !name.starts_with(begin) ||
        !name.ends_with(end)) {
      continue;
    }
    const std::string digits = name.substr(begin.size(), name.size() - begin.size() - end.size());
    const bool is_number = digits.size() <= kMostDigits && std::ranges::all_of(digits, [](char c) {
                             return std::isdigit(static_cast<unsigned char>(c)) != 0;
                           });
    if (is_number) parts.emplace(std::stoi(digits), entry.path());
  }
  if (parts.empty()) return {file};
  std::vector<std::filesystem::path> files;
  for (const auto& [number, part] : parts) files.push_back(part);
  return files;
}

}  // namespace palpate
