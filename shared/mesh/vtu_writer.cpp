#include "shared/mesh/vtu_writer.h"

#include <bit>
#include <span>
#include <stdexcept>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kLine = 3, kTriangle = 5, kTet = 10;  // vtkCellType.h

std::string Attribute(const std::string& key, const std::string& value) {
  return " " + key + "=\"" + XmlEscaped(value) + "\"";
}

// Cells in VTK's three lists.
struct Cells {
  std::vector<std::int64_t> connectivity, offsets;
  std::vector<std::uint8_t> types;

  void Add(int type, std::span<const int> nodes) {
    connectivity.insert(connectivity.end(), nodes.begin(), nodes.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(static_cast<std::uint8_t>(type));
  }
};

Cells CellsOf(const VtuGrid& grid) {
  Cells cells;
  for (const auto& tet : grid.tets) cells.Add(kTet, tet);
  for (const auto& triangle : grid.triangles) cells.Add(kTriangle, triangle);
  for (const auto& line : grid.lines) cells.Add(kLine, line);
  return cells;
}

class VtuBuilder {
 public:
  void Add(const std::string& text) { xml_ += text; }

  template <class T>
  void AddArray(const std::string& type, const std::string& attributes, std::span<const T> values) {
    xml_ += "<DataArray" + Attribute("type", type) + attributes;
    xml_ +=
        Attribute("format", "appended") + Attribute("offset", std::to_string(raw_.size())) + "/>\n";
    const std::uint64_t size = values.size_bytes();
    AppendRaw(&size, sizeof(size));
    AppendRaw(values.data(), size);
  }

  [[nodiscard]] std::string Whole() const {
    std::string whole =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"";
    whole += std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
    whole += "\" header_type=\"UInt64\">\n" + xml_;
    return whole + "<AppendedData encoding=\"raw\">\n_" + raw_ + "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  void AppendRaw(const void* bytes, std::size_t size) {
    raw_.append(static_cast<const char*>(bytes), size);
  }

  std::string xml_, raw_;
};

void AddPoints(const VtuGrid& grid, VtuBuilder* text) {
  std::vector<double> xyz;
  xyz.reserve(3 * grid.points.size());
  for (const auto& p : grid.points) xyz.insert(xyz.end(), p.begin(), p.end());
  text->Add("<Points>\n");
  text->AddArray<double>("Float64", Attribute("NumberOfComponents", "3"), xyz);
  text->Add("</Points>\n");
}

void AddCells(const Cells& cells, VtuBuilder* text) {
  text->Add("<Cells>\n");
  text->AddArray<std::int64_t>("Int64", Attribute("Name", "connectivity"), cells.connectivity);
  text->AddArray<std::int64_t>("Int64", Attribute("Name", "offsets"), cells.offsets);
  text->AddArray<std::uint8_t>("UInt8", Attribute("Name", "types"), cells.types);
  text->Add("</Cells>\n");
}

void AddPointData(const VtuGrid& grid, VtuBuilder* text) {
  text->Add("<PointData>\n");
  for (const PointArray& array : grid.arrays) {
    const std::string attributes =
        Attribute("Name", array.name) +
        Attribute("NumberOfComponents", std::to_string(array.components));
    text->AddArray<double>("Float64", attributes, array.values);
  }
  text->Add("</PointData>\n");
}

}  // namespace

std::string CaseArrayName(const std::string& quantity, const std::string& case_name,
                          std::size_t cases) {
  return cases > 1 ? quantity + " " + case_name : quantity;
}

std::string ToVtu(const VtuGrid& grid) {
  for (const PointArray& array : grid.arrays) {
    if (array.components < 1 ||
        array.values.size() != grid.points.size() * static_cast<std::size_t>(array.components)) {
      throw std::invalid_argument("array " + array.name + " of " +
                                  std::to_string(array.values.size()) + " numbers: expected " +
                                  std::to_string(array.components) + " at each of " +
                                  std::to_string(grid.points.size()) + " points");
    }
  }
  const Cells cells = CellsOf(grid);
  VtuBuilder text;
  text.Add("<UnstructuredGrid>\n<Piece" +
           Attribute("NumberOfPoints", std::to_string(grid.points.size())) +
           Attribute("NumberOfCells", std::to_string(cells.types.size())) + ">\n");
  AddPoints(grid, &text);
  AddCells(cells, &text);
  AddPointData(grid, &text);
  text.Add("</Piece>\n</UnstructuredGrid>\n");
  return text.Whole();
}

bool WriteVtu(const std::filesystem::path& file, const VtuGrid& grid) {
  return TryWrite(file, ToVtu(grid));
}

}  // namespace palpate
