#include "shared/validation/validation.h"

#include <cstdio>
#include <cstdlib>

namespace palpate {

bool IsValidating() noexcept {
#ifdef PALPATE_VALIDATES
  return true;
#else
  return false;
#endif
}

void EndOnViolation(std::string_view place, std::string_view violation) noexcept {
  std::fprintf(stderr, "%.*s: invariant violated: %.*s\n", static_cast<int>(place.size()),
               place.data(), static_cast<int>(violation.size()), violation.data());
  std::abort();
}

}  // namespace palpate
