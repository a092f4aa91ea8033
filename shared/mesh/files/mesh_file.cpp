#include "shared/mesh/files/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "shared/mesh/files/file_cursor.h"
#include "shared/mesh/files/readers.h"

namespace palpate {
namespace {

using Reader = MeshFile (*)(const std::filesystem::path&, double);
constexpr std::array<std::pair<std::string_view, Reader>, 7> kReaders{{{".veg", ReadVega},
                                                                       {".node", ReadTetgen},
                                                                       {".ele", ReadTetgen},
                                                                       {".msh", ReadGmsh},
                                                                       {".vtu", ReadVtu},
                                                                       {".stl", ReadStl},
                                                                       {".ply", ReadPly}}};

}  // namespace

MeshFile ReadMeshFile(const std::filesystem::path& file, double unit) {
  if (!(unit > 0 && std::isfinite(unit))) {
    throw std::invalid_argument("unit = " + Brief(unit) + ": accepted is a finite length > 0");
  }
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const auto& [known, read] : kReaders) {
    if (extension == known) return read(file, unit);
  }
  throw std::invalid_argument(file.string() +
                              ": unknown kind of file: accepted is .veg .node .ele .msh .vtu, for "
                              "a surface .stl .ply .msh .vtu");
}

}  // namespace palpate
