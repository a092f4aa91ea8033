// Point clouds.
#include <stdexcept>

#include "slave/study/clouds/pcd_file.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const auto file = fuzz::Write("a.pcd", {reinterpret_cast<const char*>(data), size});
  fuzz::Try<std::invalid_argument>([&] { study::ReadPcd(file); });
  return 0;
}
