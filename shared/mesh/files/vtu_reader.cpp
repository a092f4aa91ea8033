// VTK's XML unstructured grids, .vtu.
// Source: VTK file formats, "XML file formats"; cell types from vtkCellType.h.
#include <array>

#include "shared/mesh/files/mesh_builder.h"
#include "shared/mesh/files/readers.h"
#include "shared/mesh/files/vtu_data.h"

namespace palpate {
namespace {

using Use = CellKind::Use;

constexpr std::array<CellKind, 17> kKinds{{{1, 1, Use::kPassedOver, "vertex"},
                                           {2, 0, Use::kPassedOver, "set of vertices"},
                                           {3, 2, Use::kPassedOver, "line"},
                                           {4, 0, Use::kPassedOver, "chain of lines"},
                                           {5, 3, Use::kTriangle, "triangle"},
                                           {9, 4, Use::kQuad, "quadrilateral"},
                                           {10, 4, Use::kTet, "tetrahedron"},
                                           {11, 8, Use::kRefused, "voxel"},
                                           {12, 8, Use::kRefused, "hexahedron"},
                                           {13, 6, Use::kRefused, "wedge"},
                                           {14, 5, Use::kRefused, "pyramid"},
                                           {21, 3, Use::kPassedOver, "quadratic line"},
                                           {22, 6, Use::kTriangle, "quadratic triangle"},
                                           {23, 8, Use::kQuad, "quadratic quadrilateral"},
                                           {24, 10, Use::kTet, "quadratic tetrahedron"},
                                           {25, 20, Use::kRefused, "quadratic hexahedron"},
                                           {28, 9, Use::kQuad, "biquadratic quadrilateral"}}};

class VtuReader {
 public:
  explicit VtuReader(const std::filesystem::path& file)
      : cursor_(file), root_(ParseXml(&cursor_, "AppendedData")), builder_(cursor_) {}

  MeshFile Read(double unit) {
    if (root_.name != "VTKFile" || root_.Attribute("type") != "UnstructuredGrid") {
      cursor_.RefuseAt(root_.position,
                       Quoted(root_.name) + " of type " + Quoted(root_.Attribute("type")),
                       "a VTKFile of type UnstructuredGrid");
    }
    VtuData data(&cursor_, root_);
    for (const XmlElement& piece : Required(root_, "UnstructuredGrid").children) {
      if (piece.name == "Piece") ReadPiece(piece, &data);
    }
    return builder_.Finish(unit);
  }

 private:
  const XmlElement& Required(const XmlElement& parent, std::string_view name) {
    const XmlElement* child = parent.Child(name);
    if (child == nullptr) {
      cursor_.RefuseAt(parent.position, Quoted(parent.name) + " without " + std::string(name),
                       "one of these in it");
    }
    return *child;
  }

  const XmlElement& Array(const XmlElement& parent, std::string_view name) {
    for (const XmlElement& child : parent.children) {
      if (child.name == "DataArray" && child.Attribute("Name") == name) return child;
    }
    cursor_.RefuseAt(parent.position, "no DataArray " + Quoted(name), "one in Cells");
  }

  std::size_t Count(const XmlElement& piece, const char* attribute) {
    cursor_.Mark(piece.position);
    return static_cast<std::size_t>(
        ParseWhole(cursor_, piece.Attribute(attribute), attribute, 0, FileCursor::kMost));
  }

  void ReadPiece(const XmlElement& piece, VtuData* data) {
    const std::size_t points = Count(piece, "NumberOfPoints");
    const std::size_t cells = Count(piece, "NumberOfCells");
    const auto first = static_cast<std::int64_t>(builder_.node_count());
    if (points > 0) {
      const XmlElement& array = Required(Required(piece, "Points"), "DataArray");
      const std::vector<double> xyz = data->Reals(array, 3 * points);
      for (std::size_t i = 0; i < points; ++i) {
        builder_.AddNode(first + static_cast<std::int64_t>(i),
                         {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]});
      }
    }
    if (cells > 0) ReadCells(Required(piece, "Cells"), cells, first, data);
  }

  void ReadCells(const XmlElement& cells, std::size_t count, std::int64_t first_node,
                 VtuData* data) {
    const std::vector<std::int64_t> types = data->Wholes(Array(cells, "types"), count);
    const std::vector<std::int64_t> ends = data->Wholes(Array(cells, "offsets"), count);
    const XmlElement& connectivity = Array(cells, "connectivity");
    std::vector<std::int64_t> nodes = data->Wholes(connectivity, VtuData::kAny);
    const auto points = static_cast<std::int64_t>(builder_.node_count()) - first_node;
    for (std::int64_t& node : nodes) {
      if (node < 0 || node >= points) {
        cursor_.RefuseAt(connectivity.position, "point " + std::to_string(node),
                         "0 to " + std::to_string(points - 1));
      }
      node += first_node;
    }
    cursor_.Mark(connectivity.position);
    std::int64_t begin = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (ends[i] < begin || ends[i] > static_cast<std::int64_t>(nodes.size())) {
        cursor_.RefuseAt(cells.position,
                         "offset " + std::to_string(ends[i]) + " of cell " + std::to_string(i),
                         std::to_string(begin) + " to " + std::to_string(nodes.size()));
      }
      AddCell(types[i], std::span(nodes).subspan(static_cast<std::size_t>(begin),
                                                 static_cast<std::size_t>(ends[i] - begin)));
      begin = ends[i];
    }
  }

  void AddCell(std::int64_t type, std::span<const std::int64_t> nodes) {
    const std::string cell = "cell " + std::to_string(next_cell_);
    const CellKind* kind = FindKind(kKinds, type);
    if (kind == nullptr) {
      cursor_.Refuse(cell + " of type " + std::to_string(type),
                     "10 and 24 (tetrahedra), 5 and 22 (triangles)");
    }
    if (kind->nodes != 0 && static_cast<std::size_t>(kind->nodes) != nodes.size()) {
      cursor_.Refuse(cell + ", a " + std::string(kind->name) + " of " +
                         std::to_string(nodes.size()) + " points",
                     std::to_string(kind->nodes));
    }
    builder_.AddCell(*kind, next_cell_++, nodes);
  }

  FileCursor cursor_;
  XmlElement root_;
  MeshBuilder builder_;
  std::int64_t next_cell_ = 0;
};

}  // namespace

MeshFile ReadVtu(const std::filesystem::path& file, double unit) {
  return VtuReader(file).Read(unit);
}

}  // namespace palpate
