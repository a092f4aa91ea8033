// Networks in both layouts of JSON.
#include <stdexcept>

#include "slave/tactile/network/network_file.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const fuzz::Input input(data, size, 2);
  fuzz::Write(input.kind == 0 ? kNetworkFileName : kTensorsFileName, input.bytes);
  fuzz::Try<std::runtime_error>([&] {
    if (input.kind == 0) {
      ReadForceNetwork(fuzz::Folder());
    } else {
      ImportTensors(fuzz::Folder());
    }
  });
  return 0;
}
