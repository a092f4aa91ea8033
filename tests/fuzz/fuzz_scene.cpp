// Reads a scene. Every mistake must give a SceneError with short text; the text of any other
// message must be short, too.
#include <cstdlib>
#include <string>

#include "slave/commands/serve/scene_mistakes.h"
#include "slave/scene/scene_loader.h"
#include "tests/fuzz/fuzz_files.h"

namespace {

// A proposal's keys and values are as long as its author likes.
std::string WithLongKey(const std::string& word) {
  std::string key;
  while (!word.empty() && key.size() < 100'000) key += word;
  return "name: a\n? \"" + key + "\"\n: 1\n";
}

void RequireShort(const palpate::SceneMistake& mistake) {
  constexpr std::size_t kMaxMessage = 3000;
  if (mistake.key.size() + mistake.value.size() > 300) std::abort();
  if (mistake.message.size() + mistake.expected.size() > kMaxMessage) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const fuzz::Input input(data, size, 3);
  const std::string text(input.bytes.begin(), input.bytes.end());
  const auto file = fuzz::Write("scene.yaml", input.kind == 2 ? WithLongKey(text) : text);
  try {
    LoadScene(file, {}, input.kind == 0 ? SceneUse::kFull : SceneUse::kSolve);
  } catch (const SceneError& error) {
    for (const SceneMistake& mistake : MistakesOf(error)) RequireShort(mistake);
  }
  RequireShort(MistakeIn(text));
  return 0;
}
