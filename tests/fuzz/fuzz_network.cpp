// Files of force networks.
#include <stdexcept>

#include "slave/tactile/network/network_file.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  fuzz::Write(kNetworkFileName, {reinterpret_cast<const char*>(data), size});
  fuzz::Try<std::runtime_error>([] { ReadForceNetwork(fuzz::Folder()); });
  return 0;
}
