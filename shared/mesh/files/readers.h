// One reader per format; ReadMeshFile chooses. They throw std::invalid_argument as it says.
#pragma once

#include <filesystem>

#include "shared/mesh/files/mesh_file.h"

namespace palpate {

MeshFile ReadTetgen(const std::filesystem::path& file, double unit);  // .node or .ele
MeshFile ReadVega(const std::filesystem::path& file, double unit);
MeshFile ReadGmsh(const std::filesystem::path& file, double unit);
MeshFile ReadVtu(const std::filesystem::path& file, double unit);
MeshFile ReadStl(const std::filesystem::path& file, double unit);
MeshFile ReadPly(const std::filesystem::path& file, double unit);

}  // namespace palpate
