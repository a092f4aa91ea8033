#include "slave/mechanics/mesher/mesher_input.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "shared/mesh/files/mesh_file.h"
#include "shared/text/text.h"
#include "slave/mechanics/mesher/hole_points.h"

namespace palpate {
namespace {

void AppendPoints(const std::vector<Eigen::Vector3d>& points, std::string* text) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    AppendNumber(i, ' ', text);
    AppendNumber(points[i].x(), ' ', text);
    AppendNumber(points[i].y(), ' ', text);
    AppendNumber(points[i].z(), '\n', text);
  }
}

// A surface divided anew at about its own edges would only lose volume where it bends.
constexpr double kMuchLonger = 1.5;

double LongestEdge(const SurfaceMesh& surface) {
  double longest = 0;
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& a = surface.nodes[static_cast<std::size_t>(t[i])];
      const auto& b = surface.nodes[static_cast<std::size_t>(t[(i + 1) % 3])];
      longest = std::max(longest, (b - a).norm());
    }
  }
  return longest;
}

}  // namespace

void WriteTetgenInput(const std::filesystem::path& file, const SurfaceMesh& surface) {
  std::string text;
  AppendNumber(surface.nodes.size(), ' ', &text);
  text += "3 0 0\n";
  AppendPoints(surface.nodes, &text);
  AppendNumber(surface.triangles.size(), ' ', &text);
  text += "0\n";
  for (const auto& [a, b, c] : surface.triangles) {
    text += "3 ";
    AppendNumber(a, ' ', &text);
    AppendNumber(b, ' ', &text);
    AppendNumber(c, '\n', &text);
  }
  const std::vector<Eigen::Vector3d> holes = HolePoints(surface);
  AppendNumber(holes.size(), '\n', &text);
  AppendPoints(holes, &text);
  WriteWholeFile(file, text);
}

void WriteGmshInput(const std::filesystem::path& file, const SurfaceMesh& surface, double edge) {
  if (!WriteGmsh(file.parent_path() / "surface.msh", surface)) {
    throw std::runtime_error(file.string() + " cannot be written");
  }
  // Classified, a cavity is a surface of its own, which Gmsh leaves empty.
  std::string text = "Merge \"surface.msh\";\nClassifySurfaces{40*Pi/180, 1, 1, Pi};\n";
  if (edge > 0 && LongestEdge(surface) > kMuchLonger * edge) text += "CreateGeometry;\n";
  // The surface's file names a physical group; without SaveAll nothing else would be written.
  text += "Surface Loop(1) = Surface{:};\nVolume(1) = {1};\nMesh.SaveAll = 1;\n";
  if (edge > 0) {
    for (const char* bound : {"Mesh.MeshSizeMin = ", "Mesh.MeshSizeMax = "}) {
      text += bound;
      AppendNumber(edge, ';', &text);
      text += '\n';
    }
  }
  WriteWholeFile(file, text);
}

}  // namespace palpate
