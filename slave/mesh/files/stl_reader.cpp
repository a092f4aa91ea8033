// STL: triangles with three separate corners each, ASCII or binary (80 bytes, a count, 50 bytes per
// triangle, little-endian floats).
#include <array>
#include <string>

#include "shared/mesh/node_merger.h"
#include "shared/text/text.h"
#include "slave/mesh/files/mesh_builder.h"
#include "slave/mesh/files/readers.h"

namespace palpate {
namespace {

constexpr std::size_t kHeaderSize = 80, kFacetSize = 50;
constexpr double kRounding = 2e-7;  // of the largest coordinate: two steps of a float
constexpr CellKind kKind{0, 3, CellKind::Use::kTriangle, "triangle"};

using Corners = std::vector<Eigen::Vector3d>;  // three per triangle

// Some binary headers also begin with `solid`, but the count after them contains a zero byte.
bool IsText(std::string_view text) {
  const std::string_view begin = text.substr(0, 2 * kHeaderSize);
  return Trimmed(text).empty() || (Lowercase(Trimmed(begin)).starts_with("solid") &&
                                   begin.find('\0') == std::string_view::npos);
}

Corners ReadBinary(FileCursor* cursor) {
  cursor->Seek(kHeaderSize);
  cursor->set_form(NumberForm::kLittleEndian);
  const std::size_t count = cursor->Count<std::uint32_t>("count of triangles", kFacetSize);
  const std::size_t tail = cursor->rest().size() - kFacetSize * count;
  if (tail >= kFacetSize) {
    cursor->Refuse("count of triangles " + std::to_string(count),
                   std::to_string(count + tail / kFacetSize) + ", as the length of the file says");
  }
  Corners corners;
  corners.reserve(3 * count);
  while (corners.size() < 3 * count) {
    const std::size_t begin = cursor->position();
    cursor->Seek(begin + 12);  // after the normal, which also follows from the order of the corners
    for (int i = 0; i < 3; ++i) corners.push_back(cursor->Point<float>());
    cursor->Seek(begin + kFacetSize);
  }
  return corners;
}

void Expect(FileCursor* cursor, const char* word) {
  const std::string_view found = cursor->Word(word);
  if (Lowercase(found) != word) cursor->Refuse(Quoted(found), std::string("`") + word + "` here");
}

Corners ReadText(FileCursor* cursor) {
  Corners corners;
  Expect(cursor, "solid");
  std::string_view name;
  cursor->NextLine(&name);
  for (;;) {
    const std::string word = Lowercase(cursor->Word("`facet` or `endsolid`"));
    if (word == "endsolid") break;
    if (word != "facet") cursor->Refuse(Quoted(word), "`facet` or `endsolid`");
    Expect(cursor, "normal");
    for (int i = 0; i < 3; ++i) cursor->Word("a normal");
    Expect(cursor, "outer");
    Expect(cursor, "loop");
    for (int i = 0; i < 3; ++i) {
      Expect(cursor, "vertex");
      corners.push_back(cursor->Point<double>());
    }
    Expect(cursor, "endloop");
    Expect(cursor, "endfacet");
  }
  cursor->NextLine(&name);
  if (!cursor->AtEnd()) cursor->Refuse("text after `endsolid`", "one solid in a file");
  return corners;
}

}  // namespace

MeshFile ReadStl(const std::filesystem::path& file, double unit) {
  FileCursor cursor(file);
  const Corners corners = IsText(cursor.text()) ? ReadText(&cursor) : ReadBinary(&cursor);
  double largest = 0;
  for (const auto& p : corners) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  MeshBuilder builder(cursor);
  builder.RequireNear(largest * unit);
  NodeMerger merger(kRounding * largest);
  std::int64_t collapsed = 0;
  for (std::size_t t = 0; 3 * t < corners.size(); ++t) {
    std::array<std::int64_t, 3> nodes{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d& p = corners[3 * t + i];
      const int same = merger.FindOrAdd(p);
      if (static_cast<std::size_t>(same) == builder.node_count()) builder.AddNode(same, p);
      nodes[i] = same;
    }
    if (nodes[0] == nodes[1] || nodes[1] == nodes[2] || nodes[2] == nodes[0]) {
      ++collapsed;
    } else {
      builder.AddCell(kKind, static_cast<std::int64_t>(t), nodes);
    }
  }
  if (collapsed > 0) builder.Remark(std::to_string(collapsed) + " triangles of no width left out");
  return builder.Finish(unit);
}

}  // namespace palpate
