// What a running program knows of itself: its version, and where its parts are.
#pragma once

#include <filesystem>
#include <string_view>

namespace palpate {

// 0.1.0+1a2b3c4d: the release and, where the sources were under git, their commit; `.changed` after
// it: with changes of their own.
const char* Version();

// Programs and modules that work needs but starting does not stand beside the program that runs, or
// in ../lib/palpate. Empty: `name` is in neither.
std::filesystem::path FindPart(std::string_view name);

}  // namespace palpate
