#include "slave/mesh/files/mesh_file.h"

#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "shared/text/file_format.h"
#include "shared/text/text.h"
#include "slave/mesh/files/file_cursor.h"
#include "slave/mesh/files/readers.h"

namespace palpate {
namespace {

// `number x y z` per node, from 1.
void AppendNodes(const std::vector<Eigen::Vector3d>& nodes, std::string* text) {
  std::size_t number = 0;
  for (const auto& p : nodes) {
    AppendNumber(++number, ' ', text);
    AppendNumber(p.x(), ' ', text);
    AppendNumber(p.y(), ' ', text);
    AppendNumber(p.z(), '\n', text);
  }
}

// `number head corners` per element, from 1.
void AppendElement(std::size_t number, const char* head, std::span<const int> corners,
                   std::string* text) {
  AppendNumber(number, ' ', text);
  *text += head;
  for (const int i : corners) AppendNumber(i + 1, ' ', text);
  text->back() = '\n';
}

// `head`: element type, count of tags, physical and elementary entity.
template <class Element>
bool WriteGmsh2(const std::filesystem::path& file, const std::vector<Eigen::Vector3d>& nodes,
                const std::vector<Element>& elements, const char* head) {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n";
  AppendNumber(nodes.size(), '\n', &text);
  AppendNodes(nodes, &text);
  text += "$EndNodes\n$Elements\n";
  AppendNumber(elements.size(), '\n', &text);
  for (std::size_t i = 0; i < elements.size(); ++i) AppendElement(i + 1, head, elements[i], &text);
  return TryWrite(file, text + "$EndElements\n");
}

using Reader = MeshFile (*)(const std::filesystem::path&, double);
constexpr std::array<std::pair<std::string_view, Reader>, 5> kReaders{{{".node", ReadTetgen},
                                                                       {".ele", ReadTetgen},
                                                                       {".msh", ReadGmsh},
                                                                       {".stl", ReadStl},
                                                                       {".ply", ReadPly}}};

}  // namespace

bool WriteGmsh(const std::filesystem::path& file, const SolidMesh& mesh) {
  return WriteGmsh2(file, mesh.nodes, mesh.tets, "4 2 1 1 ");
}

bool WriteGmsh(const std::filesystem::path& file, const SurfaceMesh& mesh) {
  return WriteGmsh2(file, mesh.nodes, mesh.triangles, "2 2 1 1 ");
}

MeshFile ReadMeshFile(const std::filesystem::path& file, double unit) {
  if (!(unit > 0 && std::isfinite(unit))) {
    throw std::invalid_argument("unit = " + Brief(unit) + ": expected a finite length > 0");
  }
  const std::string extension = Lowercase(file.extension().string());
  for (const auto& [known, read] : kReaders) {
    if (extension == known) return read(file, unit);
  }
  const std::string foreign = ForeignFile(file);
  throw std::invalid_argument(file.string() + ": " +
                              (foreign.empty() ? "unknown kind of file" : "is " + foreign) +
                              ": expected .node .ele .msh, for a "
                              "surface .stl .ply .msh; meshio converts others");
}

}  // namespace palpate
