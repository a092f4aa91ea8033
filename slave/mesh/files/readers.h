// Each function reads one format, and ReadMeshFile chooses it. All throw the exceptions of
// ReadMeshFile.
#pragma once

#include <filesystem>

#include "slave/mesh/files/file_cursor.h"
#include "slave/mesh/files/mesh_builder.h"
#include "slave/mesh/files/mesh_file.h"

namespace palpate {

MeshFile ReadTetgen(const std::filesystem::path& file, double unit);  // .node or .ele
MeshFile ReadVega(const std::filesystem::path& file, double unit);
MeshFile ReadGmsh(const std::filesystem::path& file, double unit);
MeshFile ReadStl(const std::filesystem::path& file, double unit);
MeshFile ReadPly(const std::filesystem::path& file, double unit);

// The tables of TetGen's .node and .ele files, which Vega's .veg files also contain: `count 3
// attributes markers`, then `number x y z ...` per node; numbers increase by one from 0 or 1.
void ReadNodeTable(MeshRowReader* rows, MeshBuilder* builder);
// `count corners attributes`, then `number corners ...` per tetrahedron of 4 or 10 nodes.
void ReadElementTable(MeshRowReader* rows, MeshBuilder* builder);

}  // namespace palpate
