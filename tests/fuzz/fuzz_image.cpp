// Images of every kind that a recording may consist of.
#include <stdexcept>

#include "slave/capture/image_files.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const auto file = fuzz::Write("a.png", {reinterpret_cast<const char*>(data), size});
  fuzz::Try<std::runtime_error>([&] { ReadImage(file, 1); });
  return 0;
}
