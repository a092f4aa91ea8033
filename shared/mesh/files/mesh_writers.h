// Meshes as files that other programs read, in metres; results on meshes: vtu_writer.h. Numbers
// round-trip, except where a format keeps floats. False: the file cannot be written.
#pragma once

#include <filesystem>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// name.node and name.ele, whichever of them is named; numbered from 1.
bool WriteTetgen(const std::filesystem::path& file, const SolidMesh& mesh);
// Gmsh 2.2, ASCII, numbered from 1.
bool WriteGmsh(const std::filesystem::path& file, const SolidMesh& mesh);
bool WriteGmsh(const std::filesystem::path& file, const SurfaceMesh& mesh);
// Binary: coordinates are floats, good to seven digits.
bool WriteStl(const std::filesystem::path& file, const SurfaceMesh& mesh);

}  // namespace palpate
