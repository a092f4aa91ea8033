// Every sample by name, for tests that go through all of them.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/shared/mesh/files/sample_files.h"

namespace palpate::samples {

struct Sample {
  std::string name;  // its special property
  std::string file;  // its file name, whose extension selects the reader
  std::string bytes;

  friend std::ostream& operator<<(std::ostream& stream, const Sample& sample) {
    return stream << sample.name;
  }
};

// Files of Pair(). TetGen's two files are not among them.
inline std::vector<Sample> Solids() {
  const SolidMesh mesh = Pair();
  return {{"gmsh 2 text", "c.msh", Gmsh2Text(mesh)},
          {"gmsh 2 little", "d.msh", Gmsh2Binary(mesh, true)},
          {"gmsh 2 big", "e.msh", Gmsh2Binary(mesh, false)},
          {"gmsh 4 text", "f.msh", Gmsh4Text(mesh)},
          {"gmsh 4 little", "g.msh", Gmsh4Binary(mesh, true)},
          {"gmsh 4 big", "h.msh", Gmsh4Binary(mesh, false)}};
}

// Files of Tetrahedron().
inline std::vector<Sample> Surfaces() {
  const SurfaceMesh mesh = Tetrahedron();
  return {{"stl text", "a.stl", StlText(mesh)},
          {"stl binary", "b.stl", StlBinary(mesh)},
          {"ply text", "c.ply", Ply(mesh, "ascii")},
          {"ply little", "d.ply", Ply(mesh, "binary_little_endian")},
          {"ply big", "e.ply", Ply(mesh, "binary_big_endian")}};
}

}  // namespace palpate::samples
