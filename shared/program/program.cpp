#include "shared/program/program.h"

#include <cerrno>
#include <cstdio>

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

bool OutputIsOnFullDisk() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return false;
  // errno of an earlier failure is lost, so one more line is written, which fails for the same
  // reason.
  std::clearerr(stdout);
  return (std::fputc('\n', stdout) == EOF || std::fflush(stdout) != 0) && errno == ENOSPC;
}

}  // namespace palpate
