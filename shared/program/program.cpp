#include "shared/program/program.h"

namespace palpate {

namespace fs = std::filesystem;

fs::path FindPart(std::string_view name) {
  std::error_code error;
  const fs::path bin = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder : {bin, bin.parent_path() / "lib" / "palpate"}) {
    if (fs::is_regular_file(folder / name, error)) return folder / name;
  }
  return {};
}

}  // namespace palpate
