// What the mesher programs are given, in units of the surface's diagonal.
#pragma once

#include <filesystem>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// TetGen's .smesh: nodes, triangles, a point in every cavity. Throws std::runtime_error: it cannot
// be written.
void WriteTetgenInput(const std::filesystem::path& file, const SurfaceMesh& surface);
// Gmsh's .geo beside its surface as `surface.msh`. `edge` > 0 asks for edges of that length, and
// divides the surface anew if it has much longer ones; 0 leaves them to the program and the surface
// as it is. Throws as above.
void WriteGmshInput(const std::filesystem::path& file, const SurfaceMesh& surface, double edge);

}  // namespace palpate
