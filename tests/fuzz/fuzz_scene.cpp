// A scene: every mistake is a SceneError.
#include "slave/scene/scene_loader.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const fuzz::Input input(data, size, 2);
  const auto file = fuzz::Write("scene.yaml", input.bytes);
  fuzz::Try<SceneError>(
      [&] { LoadScene(file, {}, input.kind == 0 ? SceneUse::kFull : SceneUse::kSolve); });
  return 0;
}
