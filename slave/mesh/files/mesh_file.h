// Meshes from files and back: volumes as TetGen .node/.ele and Gmsh .msh; surfaces as STL
// and PLY, or as .msh of triangles.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

struct MeshFile {
  std::variant<SolidMesh, SurfaceMesh> mesh;  // in the file's order; not yet checked: CheckMesh
  MeshNumbers numbers;
  std::vector<std::string> remarks;  // notes about ignored or changed content
};

// Reads a mesh by its file's extension; lengths are multiplied by `unit` [m per unit of the file].
//
//   .node, .ele  one names the other; numbered from 0 or 1
//   .msh         Gmsh 2.2 and 4.1, ASCII and binary of either byte order
//   .stl         ASCII and binary; equal corners become one node
//   .ply         ASCII and binary of either byte order; vertices at the same place become one node
//
// Quadratic elements are read by their corners. Triangles in addition to tetrahedra, lines and
// points are ignored; remarks name sections and groups that are not used. A byte order mark and
// line ends of CR alone are accepted. Throws std::invalid_argument, `file:line: what: expected ...`
// (`file: byte n` in binary parts): a file that cannot be read, is malformed, cut short, larger
// than 2 GiB, or refers to missing items; elements that are no tetrahedra; `unit` not positive and
// finite.
MeshFile ReadMeshFile(const std::filesystem::path& file, double unit);

// Gmsh 2.2, ASCII, numbered from 1, in metres; numbers round-trip. Results on meshes: vtu_writer.h.
// False: the file cannot be written.
bool WriteGmsh(const std::filesystem::path& file, const SolidMesh& mesh);
bool WriteGmsh(const std::filesystem::path& file, const SurfaceMesh& mesh);

}  // namespace palpate
