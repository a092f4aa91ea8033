// ONNX files, and one estimate of what was read.
#include <stdexcept>
#include <vector>

#include "slave/tactile/network/force_network.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const auto file = fuzz::Write("a.onnx", {reinterpret_cast<const char*>(data), size});
  fuzz::Try<std::runtime_error>([&] {
    const auto network = LoadForceNetwork(file);
    std::vector<double> outputs(static_cast<std::size_t>(network->info().outputs));
    network->Windowed()->Push({}, outputs);
  });
  return 0;
}
