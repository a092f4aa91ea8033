// Reads mesh files of every format and checks the mesh. For TetGen's two files, the line `%%`
// separates them in the input.
#include <array>
#include <stdexcept>
#include <variant>

#include "slave/mesh/files/mesh_file.h"
#include "slave/mesh/mesh_check.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  constexpr std::array kNames{"a.stl", "a.ply", "a.msh", "a.node"};
  constexpr std::string_view kBetween = "%%\n";
  const fuzz::Input input(data, size, kNames.size());
  const std::string name = kNames[input.kind];
  std::string_view bytes = input.bytes;
  if (name == "a.node") {
    const auto middle = bytes.find(kBetween);
    const bool has_both = middle != std::string_view::npos;
    fuzz::Write("a.ele", has_both ? bytes.substr(middle + kBetween.size()) : std::string_view());
    bytes = bytes.substr(0, middle);
  }
  const auto file = fuzz::Write(name, bytes);
  fuzz::Try<std::invalid_argument>([&] {
    MeshFile read = ReadMeshFile(file, 1e-3);
    std::visit([&](auto& mesh) { CheckMesh(mesh, read.numbers); }, read.mesh);
  });
  return 0;
}
