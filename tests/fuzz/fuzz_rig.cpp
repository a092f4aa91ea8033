// Files of rigs, and the mapping of a point by their lenses.
#include <stdexcept>

#include "slave/vision/stereo/rig.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const auto file = fuzz::Write("rig.yaml", {reinterpret_cast<const char*>(data), size});
  fuzz::Try<std::runtime_error>([&] {
    const StereoRig rig = ReadRig(file);
    const auto ray = RayOf(rig.left, {10, 20});
    if (ray && !ray->allFinite()) std::abort();
    const auto seen = Project(rig.left, {0.01, 0.02, 0.3});
    if (seen && !seen->allFinite()) std::abort();
    if (rig.baseline() > 0) Triangulate(rig, {10, 20}, {8, 20}, 0.1);
  });
  return 0;
}
