// Certificates, keys, and the names in them.
#include <stdexcept>

#include <spdlog/spdlog.h>

#include "shared/tls/credentials.h"
#include "slave/service/roles.h"
#include "tests/fuzz/fuzz_files.h"

namespace palpate {
namespace {

void Read(std::size_t kind, std::string_view bytes) {
  if (kind == 0) {
    (void)ExpiryOf(bytes);
    return;
  }
  if (kind == 1) {
    const Identity identity = ParseIdentity(bytes);
    if (identity.role.empty() != identity.name.empty()) std::abort();
    if (MayCall(identity.role, bytes) && identity.role.empty()) std::abort();
    return;
  }
  for (const char* name : {"ca.pem", "cert.pem", "key.pem"}) fuzz::Write(name, bytes);
  WhyUntimely(fuzz::Folder());
  RequireUsable(fuzz::Folder());
}

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  spdlog::set_level(spdlog::level::off);
  const fuzz::Input input(data, size, 3);
  fuzz::Try<std::invalid_argument>([&] { Read(input.kind, input.bytes); });
  return 0;
}
