// TetGen's pair of files: name.node has the nodes, name.ele the tetrahedra.
#include <span>

#include "slave/mesh/files/readers.h"

namespace palpate {
namespace {

// Returns the number at the beginning of a row; numbers increase by one.
std::int64_t RowNumber(const MeshRowReader& rows, const char* what, std::int64_t row,
                       std::int64_t* first) {
  const std::int64_t number = rows.Whole(0, what, 0, FileCursor::kMaxCount);
  if (row == 0) *first = number;
  if (number != *first + row || *first > 1) {
    rows.Refuse(std::string(what) + " " + std::to_string(number),
                row == 0 ? "0 or 1 as the first" : std::to_string(*first + row) + " here");
  }
  return number;
}

// Returns the count at `field` of the first line; 0: the field is missing.
std::size_t DeclaredCount(const MeshRowReader& rows, std::size_t field, const char* what) {
  if (rows.fields().size() <= field) return 0;
  return static_cast<std::size_t>(rows.Whole(field, what, 0, FileCursor::kMaxCount));
}

// An additional or missing field, for example from a decimal comma, would shift the others.
void RequireFields(const MeshRowReader& rows, std::size_t expected) {
  const std::size_t count = rows.fields().size();
  if (count == expected) return;
  rows.Refuse(std::to_string(count) + " fields",
              std::to_string(expected) + ", with the attributes and markers of the first line");
}

void RequireEnd(MeshRowReader* rows) {
  if (rows->Next()) rows->Refuse(Quoted(rows->fields()[0]), "the end of the file after its rows");
}

// `count 3 attributes markers`, then `number x y z ...` per node; numbers increase by one from 0 or
// 1.
void ReadNodeTable(MeshRowReader* rows, MeshBuilder* builder) {
  rows->Require("a line `nodes 3 attributes markers`", 2);
  const std::int64_t count = rows->Whole(0, "count of nodes", 1, FileCursor::kMaxCount);
  rows->Whole(1, "dimension", 3, 3);
  const std::size_t attributes = DeclaredCount(*rows, 2, "count of attributes");
  const std::size_t further = attributes + DeclaredCount(*rows, 3, "count of markers");
  if (attributes > 0) builder->Remark("attributes of nodes are not used");
  std::int64_t first = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    rows->Require("a node `number x y z`", 4);
    RequireFields(*rows, 4 + further);
    const std::int64_t number = RowNumber(*rows, "node", i, &first);
    builder->AddNode(number, {rows->Real(1, "x"), rows->Real(2, "y"), rows->Real(3, "z")});
  }
}

// `count corners attributes`, then `number corners ...` per tetrahedron of 4 or 10 nodes.
void ReadElementTable(MeshRowReader* rows, MeshBuilder* builder) {
  rows->Require("a line `elements corners attributes`", 2);
  const std::int64_t count = rows->Whole(0, "count of elements", 1, FileCursor::kMaxCount);
  const std::int64_t corners = rows->Whole(1, "nodes per element", 4, 10);
  if (corners != 4 && corners != 10) {
    rows->Refuse("nodes per element " + std::to_string(corners), "4 or 10");
  }
  const std::size_t attributes = DeclaredCount(*rows, 2, "count of attributes");
  if (attributes > 0) {
    builder->Remark(
        "attributes of elements are not used: the whole object has the scene's material");
  }
  const CellKind kind{0, static_cast<int>(corners), CellKind::Use::kTet, "tetrahedron"};
  std::array<std::int64_t, 10> nodes{};
  const auto used = std::span(nodes).first(static_cast<std::size_t>(corners));
  std::int64_t first = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    rows->Require("an element `number corners`", used.size() + 1);
    RequireFields(*rows, 1 + used.size() + attributes);
    const std::int64_t number = RowNumber(*rows, "element", i, &first);
    for (std::size_t k = 0; k < used.size(); ++k) {
      used[k] = rows->Whole(k + 1, "node", 0, FileCursor::kMaxCount);
    }
    builder->AddCell(kind, number, used);
  }
}

}  // namespace

MeshFile ReadTetgen(const std::filesystem::path& file, double unit) {
  std::filesystem::path nodes = file, elements = file;
  MeshRowReader node_rows(nodes.replace_extension(".node"));
  MeshRowReader element_rows(elements.replace_extension(".ele"));
  MeshBuilder builder(node_rows);
  ReadNodeTable(&node_rows, &builder);
  RequireEnd(&node_rows);
  builder.set_place(element_rows);
  ReadElementTable(&element_rows, &builder);
  RequireEnd(&element_rows);
  return builder.Finish(unit);
}

}  // namespace palpate
