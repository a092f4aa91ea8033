// Networks in both layouts of JSON, and fitted localisers.
#include <stdexcept>

#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/network/network_file.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const fuzz::Input input(data, size, 3);
  const auto file = fuzz::Write(input.kind == 0 ? kNetworkFileName : kTensorsFileName, input.bytes);
  fuzz::Try<std::runtime_error>([&] {
    if (input.kind == 0) {
      ReadForceNetwork(fuzz::Folder());
    } else if (input.kind == 1) {
      ImportTensors(fuzz::Folder());
    } else {
      ReadLocaliser(file);
    }
  });
  return 0;
}
