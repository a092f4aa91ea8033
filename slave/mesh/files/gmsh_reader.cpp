// Gmsh's .msh, versions 2 and 4.1, ASCII and binary.
// Source: Gmsh reference manual, "MSH file format" and "MSH file format version 2 (Legacy)".
#include <array>
#include <set>
#include <string>

#include "slave/mesh/files/mesh_builder.h"
#include "slave/mesh/files/readers.h"

namespace palpate {
namespace {

using Use = CellKind::Use;

constexpr std::array<CellKind, 23> kKinds{{{1, 2, Use::kPassedOver, "line"},
                                           {2, 3, Use::kTriangle, "triangle"},
                                           {3, 4, Use::kQuad, "quadrangle"},
                                           {4, 4, Use::kTet, "tetrahedron"},
                                           {5, 8, Use::kRefused, "hexahedron"},
                                           {6, 6, Use::kRefused, "prism"},
                                           {7, 5, Use::kRefused, "pyramid"},
                                           {8, 3, Use::kPassedOver, "quadratic line"},
                                           {9, 6, Use::kTriangle, "quadratic triangle"},
                                           {10, 9, Use::kQuad, "quadratic quadrangle"},
                                           {11, 10, Use::kTet, "quadratic tetrahedron"},
                                           {12, 27, Use::kRefused, "quadratic hexahedron"},
                                           {13, 18, Use::kRefused, "quadratic prism"},
                                           {14, 14, Use::kRefused, "quadratic pyramid"},
                                           {15, 1, Use::kPassedOver, "point"},
                                           {16, 8, Use::kQuad, "quadratic quadrangle"},
                                           {17, 20, Use::kRefused, "quadratic hexahedron"},
                                           {18, 15, Use::kRefused, "quadratic prism"},
                                           {19, 13, Use::kRefused, "quadratic pyramid"},
                                           {20, 9, Use::kTriangle, "cubic triangle"},
                                           {21, 10, Use::kTriangle, "cubic triangle"},
                                           {26, 4, Use::kPassedOver, "cubic line"},
                                           {29, 20, Use::kTet, "cubic tetrahedron"}}};

constexpr std::size_t kMaxNodes = 27;  // largest number of nodes of a kind of element
constexpr std::int64_t kMaxTag = std::int64_t{1} << 60;

class GmshReader {
 public:
  explicit GmshReader(const std::filesystem::path& file) : cursor_(file), builder_(cursor_) {}

  MeshFile Read(double unit) {
    ReadFormat();
    while (!cursor_.AtEnd()) ReadSection();
    if (has_group_names_ || groups_.size() > 1) {
      builder_.Remark("physical groups are not used: the whole object has the scene's material");
    }
    return builder_.Finish(unit);
  }

 private:
  void ReadFormat() {
    if (cursor_.Word("$MeshFormat") != "$MeshFormat") {
      cursor_.Refuse("the file does not begin with $MeshFormat", "a Gmsh file");
    }
    const std::string version(cursor_.Word("a version"));
    if (version != "2" && version != "2.1" && version != "2.2" && version != "4.1") {
      cursor_.Refuse("version " + Quoted(version), "2.2 or 4.1");
    }
    version_4_ = version == "4.1";
    const bool binary = cursor_.Whole<int>("file type", 0, 1) == 1;
    cursor_.Whole<int>("data size", 8, 8);
    if (binary) ReadByteOrder();
    End("$EndMeshFormat");
  }

  // Reads the integer one, which shows the byte order of the writer.
  void ReadByteOrder() {
    std::string_view rest_of_line;
    cursor_.NextLine(&rest_of_line);
    const std::string_view one = cursor_.rest().substr(0, 4);
    numbers_ = one.starts_with('\0') ? NumberForm::kBigEndian : NumberForm::kLittleEndian;
    cursor_.set_form(numbers_);
    cursor_.Whole<std::int32_t>("byte order mark", 1, 1);
  }

  void ReadSection() {
    const std::string name(cursor_.Word("a section"));
    if (!name.starts_with('$') || name.starts_with("$End")) {
      cursor_.Refuse(Quoted(name), "the beginning of a section, $...");
    }
    if (name == "$Nodes") {
      version_4_ ? ReadNodes4() : ReadNodes2();
    } else if (name == "$Elements") {
      version_4_ ? ReadElements4() : ReadElements2();
    } else if (name == "$ParametricNodes") {
      cursor_.Refuse(name, "$Nodes (in Gmsh without Mesh.SaveParametric)");
    } else {
      if (name == "$PhysicalNames") {
        has_group_names_ = true;
      } else if (name != "$Entities" && name != "$Comments") {
        builder_.Remark("section " + Quoted(name) + " is not used");
      }
      PassOver("$End" + name.substr(1));
      return;
    }
    End("$End" + name.substr(1));
  }

  void PassOver(const std::string& end) {
    const std::size_t found = cursor_.text().find("\n" + end, cursor_.position());
    if (found == std::string_view::npos) cursor_.Refuse("the file ends", end + " before it");
    cursor_.Seek(found);
    End(end);
  }

  void End(const std::string& end) {
    const std::string_view word = cursor_.Word(end.c_str());
    if (word != end) cursor_.Refuse(Quoted(word), end + " here");
  }

  // Binary numbers begin after the end of the line.
  void BeginNumbers() {
    std::string_view rest_of_line;
    if (numbers_ != NumberForm::kText) cursor_.NextLine(&rest_of_line);
  }

  // Version 2 writes counts as text in both text and binary files.
  std::size_t CountOfLine(const char* what, std::size_t bytes_each) {
    cursor_.set_form(NumberForm::kText);
    const std::size_t count = cursor_.Count<int>(what, bytes_each);
    BeginNumbers();
    cursor_.set_form(numbers_);
    return count;
  }

  // Returns the smallest size of an entry; a number in text takes at least two characters, `0` and
  // a blank.
  [[nodiscard]] std::size_t Size(std::size_t integers, std::size_t integer_size,
                                 std::size_t reals) const {
    return numbers_ == NumberForm::kText ? 2 * (integers + reals)
                                         : integer_size * integers + 8 * reals;
  }

  void ReadNodes2() {
    const std::size_t count = CountOfLine("count of nodes", Size(1, 4, 3) - 1);
    builder_.ReserveNodes(count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t number = cursor_.Whole<std::int32_t>("node", 0, kMaxTag);
      builder_.AddNode(number, cursor_.Point<double>());
    }
  }

  void ReadElements2() {
    std::size_t left = CountOfLine("count of elements", Size(3, 4, 0) - 4);
    const bool text = numbers_ == NumberForm::kText;
    while (left > 0) {
      // In text every element is a separate block that begins with its number.
      std::int64_t number = text ? cursor_.Whole<int>("element", 0, kMaxTag) : 0;
      const CellKind& kind = Kind();
      const std::int64_t block = text
                                     ? 1
                                     : cursor_.Whole<std::int32_t>("elements in block", 1,
                                                                   static_cast<std::int64_t>(left));
      const std::int64_t tags = cursor_.Whole<std::int32_t>("count of tags", 0, 1000);
      for (std::int64_t i = 0; i < block; ++i) {
        if (!text) number = cursor_.Whole<std::int32_t>("element", 0, kMaxTag);
        for (std::int64_t t = 0; t < tags; ++t) {
          const std::int64_t tag = cursor_.Whole<std::int32_t>("tag", -kMaxTag, kMaxTag);
          // The first tag is the physical group.
          if (t == 0 && kind.use == Use::kTet) groups_.insert(tag);
        }
        ReadCell<std::int32_t>(kind, number);
      }
      left -= static_cast<std::size_t>(block);
    }
  }

  void ReadNodes4() {
    BeginNumbers();
    cursor_.set_form(numbers_);
    const std::size_t blocks = cursor_.Count<std::uint64_t>("count of blocks", Size(4, 4, 0));
    std::size_t left = cursor_.Count<std::uint64_t>("count of nodes", Size(1, 8, 3));
    SkipRange();
    builder_.ReserveNodes(left);
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = cursor_.Whole<std::int32_t>("dimension", 0, 3);
      cursor_.Whole<std::int32_t>("entity", -kMaxTag, kMaxTag);
      const bool parametric = cursor_.Whole<std::int32_t>("parametric", 0, 1) == 1;
      const std::int64_t count = BlockCount("nodes in block", left);
      ReadBlock4(count, parametric ? dimension : 0);
      left -= static_cast<std::size_t>(count);
    }
    RequireNoneLeft(left, "nodes");
  }

  void ReadBlock4(std::int64_t count, std::int64_t parameters) {
    std::vector<std::int64_t> numbers;
    for (std::int64_t i = 0; i < count; ++i) {
      numbers.push_back(cursor_.Whole<std::uint64_t>("node", 0, kMaxTag));
    }
    for (const std::int64_t number : numbers) {
      builder_.AddNode(number, cursor_.Point<double>());
      for (std::int64_t k = 0; k < parameters; ++k) cursor_.Real<double>("parameter");
    }
  }

  void ReadElements4() {
    BeginNumbers();
    cursor_.set_form(numbers_);
    const std::size_t blocks = cursor_.Count<std::uint64_t>("count of blocks", Size(4, 4, 0));
    std::size_t left = cursor_.Count<std::uint64_t>("count of elements", Size(2, 8, 0) - 1);
    SkipRange();
    for (std::size_t b = 0; b < blocks; ++b) {
      cursor_.Whole<std::int32_t>("dimension", 0, 3);
      const std::int64_t entity = cursor_.Whole<std::int32_t>("entity", -kMaxTag, kMaxTag);
      const CellKind& kind = Kind();
      if (kind.use == Use::kTet) groups_.insert(entity);
      const std::int64_t count = BlockCount("elements in block", left);
      for (std::int64_t i = 0; i < count; ++i) {
        ReadCell<std::uint64_t>(kind, cursor_.Whole<std::uint64_t>("element", 0, kMaxTag));
      }
      left -= static_cast<std::size_t>(count);
    }
    RequireNoneLeft(left, "elements");
  }

  // Skips the smallest and the largest number.
  void SkipRange() {
    cursor_.Whole<std::uint64_t>("smallest number", 0, kMaxTag);
    cursor_.Whole<std::uint64_t>("largest number", 0, kMaxTag);
  }
  std::int64_t BlockCount(const char* what, std::size_t left) {
    return cursor_.Whole<std::uint64_t>(what, 0, static_cast<std::int64_t>(left));
  }
  void RequireNoneLeft(std::size_t left, const char* what) {
    if (left == 0) return;
    cursor_.Refuse(std::to_string(left) + " " + what + " are in no block",
                   "blocks that add up to the count");
  }

  const CellKind& Kind() {
    const std::int64_t code = cursor_.Whole<std::int32_t>("element type", 1, 1000);
    const CellKind* kind = FindKind(kKinds, code);
    if (kind == nullptr) {
      cursor_.Refuse("element type " + std::to_string(code),
                     "4 and 11 (tetrahedra), 2 and 9 (triangles)");
    }
    return *kind;
  }

  template <class T>
  void ReadCell(const CellKind& kind, std::int64_t number) {
    std::array<std::int64_t, kMaxNodes> nodes{};
    const auto used = std::span(nodes).first(static_cast<std::size_t>(kind.nodes));
    for (std::int64_t& node : used) node = cursor_.Whole<T>("node", 0, kMaxTag);
    builder_.AddCell(kind, number, used);
  }

  FileCursor cursor_;
  MeshBuilder builder_;
  bool version_4_ = false;
  NumberForm numbers_ = NumberForm::kText;
  bool has_group_names_ = false;
  std::set<std::int64_t> groups_;  // of the tetrahedra
};

}  // namespace

MeshFile ReadGmsh(const std::filesystem::path& file, double unit) {
  return GmshReader(file).Read(unit);
}

}  // namespace palpate
