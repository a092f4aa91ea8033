// Paths of files that tests read and write. They are functions, not macros: a path of this checkout
// in the command line of every unit would prevent clones from sharing the compiler cache.
#pragma once

#include <string>
#include <string_view>

namespace palpate {

// `below` the project's root, "/../shared/reference/c_plate.json" say.
std::string SourcePath(std::string_view below = {});
// `below` the folder that this build fills.
std::string BinaryPath(std::string_view below = {});

}  // namespace palpate
