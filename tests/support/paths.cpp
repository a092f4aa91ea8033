#include "tests/support/paths.h"

namespace palpate {

std::string SourcePath(std::string_view below) {
  return PALPATE_SOURCE_DIR + std::string(below);
}

std::string BinaryPath(std::string_view below) {
  return PALPATE_BINARY_DIR + std::string(below);
}

}  // namespace palpate
