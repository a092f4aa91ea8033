// Malformed files are refused with the line and the reason.
#include <cmath>
#include <ostream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mesh/files/mesh_file.h"
#include "tests/shared/mesh/files/all_samples.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

std::string Refusal(const std::filesystem::path& file, double unit = 1) {
  return Thrown<std::invalid_argument>([&] { ReadMeshFile(file, unit); });
}

struct Malformed {
  const char* file;
  const char* bytes;
  const char* refusal;  // error message after the folder's path

  friend std::ostream& operator<<(std::ostream& stream, const Malformed& malformed) {
    return stream << malformed.file << malformed.refusal;
  }
};

class MalformedMeshTest : public ::testing::TestWithParam<Malformed> {};

TEST_P(MalformedMeshTest, IsRefusedWithPlaceAndReason) {
  const Scratch folder;
  // TetGen's files come in pairs.
  folder.Write("a.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
  folder.Write("a.ele", "1 4 0\n1 1 2 3 4\n");
  const auto file = folder.Write(GetParam().file, GetParam().bytes);
  EXPECT_EQ(Refusal(file), file.string() + GetParam().refusal);
}

#define GMSH "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define PLY "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"

INSTANTIATE_TEST_SUITE_P(
    Files, MalformedMeshTest,
    ::testing::Values(
        Malformed{"a.vtu", "",
                  ": unknown kind of file: expected .node .ele .msh, for a "
                  "surface .stl .ply .msh; meshio converts others"},
        Malformed{"a.msh", GMSH,
                  ":3: no element was found: expected tetrahedra, or triangles for "
                  "a surface"},
        Malformed{"a.node", "2 3 0 0\n0 0 0 0\n",
                  ":3: the file ends: expected a node `number x y z` here"},
        Malformed{"a.node", "-3 3 0 0\n",
                  ":1: count of nodes '-3': expected a whole number from 1 to 2000000000"},
        Malformed{"a.node", "1 3 0 0\n0 0 nan 0\n", ":2: y 'nan': expected a finite number"},
        Malformed{"a.node", "2 3 0 0\n0 0 0 0\n2 0 0 0\n", ":3: node 2: expected 1 here"},
        Malformed{"a.ele", "1 4 0\n1 1 1 1 0\n",
                  ":2: node 0: expected a node of the file, from 1 to 4"},
        Malformed{"a.msh", "solid\n",
                  ":1: the file does not begin with $MeshFormat: expected a Gmsh file"},
        Malformed{"a.msh", GMSH "$Nodes\n1999999999\n1 0 0 0\n",
                  ":5: count of nodes 1999999999: expected at most 1, what the rest of the file "
                  "has room for"},
        Malformed{"a.msh", GMSH "$Nodes\n2\n1 0 0 0\n1 0 0 0\n$EndNodes\n",
                  ":7: node 1 again: expected every number once"},
        Malformed{"a.msh",
                  GMSH "$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n7 5 0 1 1 1 1 1 1 1 "
                       "1\n$EndElements\n",
                  ":10: element 7 is a hexahedron: expected tetrahedra, or triangles for a "
                  "surface"},
        Malformed{"a.msh", GMSH "$Comments\nnever ends\n",
                  ":4: the file ends: expected $EndComments before it"},
        Malformed{"a.stl", "solid a\n facet normal 0 0 0\n outer loop\n vertex 0 0\n endloop\n",
                  ":5: z 'endloop': expected a finite number"},
        Malformed{"a.stl",
                  "solid a\nfacet normal 0 0 0\nouter loop\nvertex 1.7976931348623157e308 0 0\n"
                  "vertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid\n",
                  ":9: a coordinate of 1.798e+308 m: expected at most 1e+15 m"},
        Malformed{"a.ply", "plx\n", ":1: the file does not begin with `ply`: expected a PLY file"},
        Malformed{"a.ply", PLY "end_header\n0 0\n0 1\n1 0\n",
                  ":7: vertices without x, y and z: expected these three properties"}));

TEST(MeshUnitTest, RefusesUnitsThatAreNone) {
  const Scratch folder;
  const auto file = folder.Write("a.msh", samples::Gmsh2Text(samples::Pair()));
  for (const double unit : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(Refusal(file, unit), HasSubstr("expected a finite length > 0"));
  }
  EXPECT_THAT(Refusal(file, 1e300), HasSubstr("expected at most 1e+15 m"));
  EXPECT_THAT(Refusal(folder / "none.msh"), HasSubstr("cannot be read"));
  EXPECT_THAT(Refusal((folder / "a.msh").parent_path() / ""), HasSubstr("unknown kind of file"));
}

}  // namespace
}  // namespace palpate
