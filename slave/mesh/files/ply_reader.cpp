// PLY: a text header that names elements and their properties, then their numbers, ASCII or binary.
// Source: G. Turk, "The PLY polygon file format" (1994).
#include <array>
#include <sstream>
#include <string>
#include <vector>

#include "shared/mesh/node_merger.h"
#include "shared/text/text.h"
#include "slave/mesh/files/mesh_builder.h"
#include "slave/mesh/files/readers.h"

namespace palpate {
namespace {

using Use = CellKind::Use;

enum class Scalar { kInt8, kUInt8, kInt16, kUInt16, kInt32, kUInt32, kFloat, kDouble };
struct ScalarName {
  std::string_view name, sized;
  Scalar scalar;
  std::size_t bytes;
};
constexpr std::array<ScalarName, 8> kScalars{{{"char", "int8", Scalar::kInt8, 1},
                                              {"uchar", "uint8", Scalar::kUInt8, 1},
                                              {"short", "int16", Scalar::kInt16, 2},
                                              {"ushort", "uint16", Scalar::kUInt16, 2},
                                              {"int", "int32", Scalar::kInt32, 4},
                                              {"uint", "uint32", Scalar::kUInt32, 4},
                                              {"float", "float32", Scalar::kFloat, 4},
                                              {"double", "float64", Scalar::kDouble, 8}}};

constexpr CellKind kTriangle{0, 3, Use::kTriangle, "triangle"};
constexpr CellKind kQuad{0, 4, Use::kQuad, "quadrilateral"};

struct Property {
  std::string name;
  const ScalarName* type = nullptr;
  const ScalarName* count_type = nullptr;  // of a list
};
struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& file) : cursor_(file), builder_(cursor_) {}

  MeshFile Read(double unit) {
    ReadHeader();
    for (const Element& element : elements_) {
      RequireRoom(element);
      for (std::int64_t i = 0; i < element.count; ++i) ReadRow(element, i);
    }
    if (const std::size_t merged = node_of_.size() - builder_.node_count(); merged > 0) {
      builder_.Remark(std::to_string(merged) +
                      " vertices coincide with others: they share one node");
    }
    return builder_.Finish(unit);
  }

 private:
  void ReadHeader() {
    std::string_view line;
    const bool has_line = cursor_.NextLine(&line);
    if (line.starts_with("ply\r")) cursor_.Refuse("line ends of CR alone", "LF or CR LF");
    if (!has_line || (Trimmed(line) != "ply" && Trimmed(line) != "PLY")) {
      cursor_.Refuse("the file does not begin with `ply`", "a PLY file");
    }
    NumberForm form = NumberForm::kText;
    bool has_format = false;
    for (;;) {
      if (!cursor_.NextLine(&line)) cursor_.Refuse("the file ends", "end_header before it");
      std::istringstream words{std::string(line)};
      std::string key;
      words >> key;
      if (key == "end_header") break;
      if (key == "format") {
        form = Format(&words);
        has_format = true;
      } else if (key == "element") {
        AddElement(&words);
      } else if (key == "property") {
        AddProperty(&words);
      } else if (key != "comment" && key != "obj_info" && !key.empty()) {
        cursor_.Refuse(Quoted(key), "format, element, property, comment or end_header");
      }
    }
    if (!has_format) cursor_.Refuse("a header without format", "ascii or binary");
    cursor_.set_form(form);
  }

  NumberForm Format(std::istringstream* words) {
    std::string name;
    *words >> name;
    if (name == "ascii") return NumberForm::kText;
    if (name == "binary_little_endian") return NumberForm::kLittleEndian;
    if (name == "binary_big_endian") return NumberForm::kBigEndian;
    cursor_.Refuse("format " + Quoted(name), "ascii, binary_little_endian or binary_big_endian");
  }

  void AddElement(std::istringstream* words) {
    Element element;
    std::string count;
    *words >> element.name >> count;
    element.count = ParseWhole(cursor_, count, "count of elements", 0, FileCursor::kMaxCount);
    elements_.push_back(std::move(element));
  }

  void AddProperty(std::istringstream* words) {
    if (elements_.empty()) cursor_.Refuse("a property without element", "element before it");
    Property property;
    std::string type;
    *words >> type;
    if (type == "list") {
      std::string count_type;
      *words >> count_type >> type;
      property.count_type = &Type(count_type);
      if (property.count_type->scalar >= Scalar::kFloat) {
        cursor_.Refuse("a list counted by " + Quoted(count_type), "a whole number's type");
      }
    }
    property.type = &Type(type);
    *words >> property.name;
    elements_.back().properties.push_back(std::move(property));
  }

  const ScalarName& Type(const std::string& name) {
    for (const ScalarName& scalar : kScalars) {
      if (name == scalar.name || name == scalar.sized) return scalar;
    }
    cursor_.Refuse("type " + Quoted(name),
                   "char, uchar, short, ushort, int, uint, float or double");
  }

  void RequireRoom(const Element& element) {
    std::size_t bytes = 0;
    for (const Property& p : element.properties) {
      const auto* type = p.count_type != nullptr ? p.count_type : p.type;
      bytes += cursor_.form() == NumberForm::kText ? 2 : type->bytes;
    }
    if (bytes == 0 && element.count > 0) {
      cursor_.Refuse("element " + Quoted(element.name) + " without properties", "one or more");
    }
    // A final line end may be missing.
    const std::size_t slack = cursor_.form() == NumberForm::kText ? 1 : 0;
    if (element.count > 0) {
      cursor_.RequireRoom(("count of " + element.name).c_str(),
                          static_cast<std::size_t>(element.count), bytes - slack);
    }
  }

  double Number(Scalar type, const char* what) {
    switch (type) {
      case Scalar::kFloat:
        return cursor_.Real<float>(what);
      case Scalar::kDouble:
        return cursor_.Real<double>(what);
      default:
        return static_cast<double>(WholeNumber(type, what));
    }
  }

  std::int64_t WholeNumber(Scalar type, const char* what) {
    constexpr std::int64_t kMaxValue = std::int64_t{1} << 40;
    switch (type) {
      case Scalar::kInt8:
        return cursor_.Whole<std::int8_t>(what, -kMaxValue, kMaxValue);
      case Scalar::kUInt8:
        return cursor_.Whole<std::uint8_t>(what, -kMaxValue, kMaxValue);
      case Scalar::kInt16:
        return cursor_.Whole<std::int16_t>(what, -kMaxValue, kMaxValue);
      case Scalar::kUInt16:
        return cursor_.Whole<std::uint16_t>(what, -kMaxValue, kMaxValue);
      case Scalar::kInt32:
        return cursor_.Whole<std::int32_t>(what, -kMaxValue, kMaxValue);
      case Scalar::kUInt32:
        return cursor_.Whole<std::uint32_t>(what, -kMaxValue, kMaxValue);
      default:
        cursor_.Refuse(std::string(what) + " that is not a whole number", "int or uint");
    }
  }

  void ReadRow(const Element& element, std::int64_t row) {
    const bool vertex = element.name == "vertex", face = element.name == "face";
    Eigen::Vector3d p = Eigen::Vector3d::Constant(std::nan(""));
    for (const Property& property : element.properties) {
      if (property.count_type != nullptr) {
        const bool corners =
            face && (property.name == "vertex_indices" || property.name == "vertex_index");
        corners ? ReadFace(property, row) : PassOver(property);
        continue;
      }
      const double value = Number(property.type->scalar, property.name.c_str());
      if (property.name == "x") p.x() = value;
      if (property.name == "y") p.y() = value;
      if (property.name == "z") p.z() = value;
    }
    if (!vertex) return;
    if (!p.allFinite()) cursor_.Refuse("vertices without x, y and z", "these three properties");
    const int node = merger_.FindOrAdd(p);
    if (static_cast<std::size_t>(node) == builder_.node_count()) builder_.AddNode(node, p);
    node_of_.push_back(node);
  }

  std::int64_t ListCount(const Property& list) {
    const std::int64_t count = WholeNumber(list.count_type->scalar, "count of a list");
    if (count < 0) cursor_.Refuse("count of a list " + std::to_string(count), "0 or more");
    const std::size_t bytes = cursor_.form() == NumberForm::kText ? 1 : list.type->bytes;
    cursor_.RequireRoom("count of a list", static_cast<std::size_t>(count), bytes);
    return count;
  }

  void PassOver(const Property& list) {
    for (std::int64_t left = ListCount(list); left > 0; --left) {
      Number(list.type->scalar, list.name.c_str());
    }
  }

  void ReadFace(const Property& list, std::int64_t row) {
    const std::int64_t count = ListCount(list);
    if (count != 3 && count != 4) {
      cursor_.Refuse("face " + std::to_string(row) + " of " + std::to_string(count) + " corners",
                     "3 or 4");
    }
    std::array<std::int64_t, 4> corners{};
    const auto used = std::span(corners).first(static_cast<std::size_t>(count));
    for (std::int64_t& corner : used) {
      const std::int64_t vertex = WholeNumber(list.type->scalar, "vertex");
      if (vertex < 0 || vertex >= static_cast<std::int64_t>(node_of_.size())) {
        cursor_.Refuse("vertex " + std::to_string(vertex),
                       std::to_string(node_of_.size()) + " vertices, from 0, before the faces");
      }
      corner = node_of_[static_cast<std::size_t>(vertex)];
    }
    builder_.AddCell(count == 3 ? kTriangle : kQuad, row, used);
  }

  FileCursor cursor_;
  MeshBuilder builder_;
  std::vector<Element> elements_;
  // Merges vertices at equal positions, because some programs write separate vertices for each
  // face.
  NodeMerger merger_{0};
  std::vector<int> node_of_;  // of each vertex
};

}  // namespace

MeshFile ReadPly(const std::filesystem::path& file, double unit) {
  return PlyReader(file).Read(unit);
}

}  // namespace palpate
