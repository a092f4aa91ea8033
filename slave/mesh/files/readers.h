// Each function reads one format, and ReadMeshFile chooses it. All throw the exceptions of
// ReadMeshFile.
#pragma once

#include <filesystem>

#include "slave/mesh/files/file_cursor.h"
#include "slave/mesh/files/mesh_builder.h"
#include "slave/mesh/files/mesh_file.h"

namespace palpate {

MeshFile ReadTetgen(const std::filesystem::path& file, double unit);  // .node or .ele
MeshFile ReadGmsh(const std::filesystem::path& file, double unit);
MeshFile ReadStl(const std::filesystem::path& file, double unit);
MeshFile ReadPly(const std::filesystem::path& file, double unit);

}  // namespace palpate
