// Paths of files that tests read and write. They are functions, not macros: a path of this checkout
// in the command line of every unit would prevent clones from sharing the compiler cache.
#pragma once

#include <string>
#include <string_view>

namespace palpate {

// Returns a path relative to the project's root, such as "/../shared/reference/c_plate.json".
std::string SourcePath(std::string_view below = {});
// `below` the folder that this build fills.
std::string BinaryPath(std::string_view below = {});

}  // namespace palpate
