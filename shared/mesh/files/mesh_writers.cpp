#include "shared/mesh/files/mesh_writers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <span>
#include <string>

#include "shared/mesh/surface_patch.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

bool Write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.flush();
  return stream.good();
}

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
  return Write(file, text + "$EndElements\n");
}

template <class T>
void AppendLittleEndian(T value, std::string* bytes) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::ranges::reverse(raw);
  bytes->append(raw.data(), raw.size());
}

void AppendFloats(const Eigen::Vector3d& v, std::string* bytes) {
  for (const double c : v) AppendLittleEndian(static_cast<float>(c), bytes);
}

}  // namespace

bool WriteTetgen(const std::filesystem::path& file, const SolidMesh& mesh) {
  std::filesystem::path node_file = file, element_file = file;
  std::string text = std::to_string(mesh.nodes.size()) + " 3 0 0\n";
  AppendNodes(mesh.nodes, &text);
  if (!Write(node_file.replace_extension(".node"), text)) return false;
  text = std::to_string(mesh.tets.size()) + " 4 0\n";
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    AppendElement(i + 1, "", mesh.tets[i], &text);
  }
  return Write(element_file.replace_extension(".ele"), text);
}

bool WriteGmsh(const std::filesystem::path& file, const SolidMesh& mesh) {
  return WriteGmsh2(file, mesh.nodes, mesh.tets, "4 2 1 1 ");
}

bool WriteGmsh(const std::filesystem::path& file, const SurfaceMesh& mesh) {
  return WriteGmsh2(file, mesh.nodes, mesh.triangles, "2 2 1 1 ");
}

bool WriteStl(const std::filesystem::path& file, const SurfaceMesh& mesh) {
  std::string bytes = "binary STL [m]";  // `solid` would announce text
  bytes.resize(80, ' ');
  AppendLittleEndian(static_cast<std::uint32_t>(mesh.triangles.size()), &bytes);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    AppendFloats(Normal(mesh, static_cast<int>(t)), &bytes);
    for (const int i : mesh.triangles[t]) {
      AppendFloats(mesh.nodes[static_cast<std::size_t>(i)], &bytes);
    }
    AppendLittleEndian(std::uint16_t{0}, &bytes);
  }
  return Write(file, bytes);
}

}  // namespace palpate
