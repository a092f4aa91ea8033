// Where tests find what they read and leave what they write. Functions, not macros: a path of this
// checkout in every unit's command line would keep clones from sharing what was compiled.
#pragma once

#include <string>
#include <string_view>

namespace palpate {

// `below` the project's root, "/../shared/reference/c_plate.json" say.
std::string SourcePath(std::string_view below = {});
// `below` the folder that this build fills.
std::string BinaryPath(std::string_view below = {});

}  // namespace palpate
