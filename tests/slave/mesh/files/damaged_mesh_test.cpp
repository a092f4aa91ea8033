// Damaged files: never a crash, a hang or a mesh that cannot be indexed.
#include <array>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mesh/files/mesh_file.h"
#include "tests/shared/mesh/files/all_samples.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// Truncates every file at every byte and changes every byte in three ways. Each file must be read
// or refused with std::invalid_argument, without a finding of the sanitizers. Indices of a mesh
// that was read must be valid.
class DamagedMeshTest : public ::testing::TestWithParam<samples::Sample> {
 protected:
  // TetGen's files come in pairs: the other one is whole.
  DamagedMeshTest() {
    folder_.Write("pair.node", samples::Node(samples::Pair(), 0));
    folder_.Write("pair.ele", samples::Ele(samples::Pair(), 0));
  }
  // Returns whether the file was read.
  bool Survives(const std::string& bytes) {
    const auto file = folder_.Write(GetParam().file, bytes);
    try {
      const MeshFile read = ReadMeshFile(file, 1);
      std::visit(
          [](const auto& mesh) {
            for (const auto& p : mesh.nodes) EXPECT_TRUE(p.allFinite());
            ExpectIndexed(mesh);
          },
          read.mesh);
      return true;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("expected"));
      return false;
    }
  }

 private:
  static void ExpectIndexed(const SolidMesh& mesh) { ExpectIn(mesh.tets, mesh.nodes.size()); }
  static void ExpectIndexed(const SurfaceMesh& mesh) {
    ExpectIn(mesh.triangles, mesh.nodes.size());
  }
  template <class Elements>
  static void ExpectIn(const Elements& elements, std::size_t nodes) {
    for (const auto& element : elements) {
      for (const int i : element) EXPECT_TRUE(i >= 0 && i < static_cast<int>(nodes)) << i;
    }
  }

  Scratch folder_;
};

TEST_P(DamagedMeshTest, IsReadOrRefusedWhereverItIsCut) {
  const std::string& bytes = GetParam().bytes;
  EXPECT_TRUE(Survives(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) Survives(bytes.substr(0, size));
  EXPECT_FALSE(Survives(bytes.substr(0, bytes.size() / 2)));
}

TEST_P(DamagedMeshTest, IsReadOrRefusedWhateverByteIsWrong) {
  const std::string& bytes = GetParam().bytes;
  constexpr std::array<char, 6> kWrong{'\0', '\xff', '9', '-', ' ', '<'};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char flipped = static_cast<char>(bytes[i] ^ 1);
    for (const char wrong : {flipped, kWrong[i % 6], kWrong[(i + 3) % 6]}) {
      std::string damaged = bytes;
      damaged[i] = wrong;
      Survives(damaged);
    }
  }
}

std::vector<samples::Sample> AllSamples() {
  auto all = samples::Solids();
  all.push_back({"tetgen nodes", "pair.node", samples::Node(samples::Pair(), 0)});
  all.push_back({"tetgen elements", "pair.ele", samples::Ele(samples::Pair(), 0)});
  for (auto& sample : samples::Surfaces()) all.push_back(std::move(sample));
  return all;
}
INSTANTIATE_TEST_SUITE_P(Samples, DamagedMeshTest, ::testing::ValuesIn(AllSamples()));

}  // namespace
}  // namespace palpate
