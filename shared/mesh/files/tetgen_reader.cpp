// TetGen's pair of files: name.node has the nodes, name.ele the tetrahedra.
#include "shared/mesh/files/readers.h"
#include "shared/mesh/files/tetgen_table.h"

namespace palpate {
namespace {

void RequireEnd(RowReader* rows) {
  if (rows->Next()) rows->Refuse(Quoted(rows->fields()[0]), "the end of the file after its rows");
}

}  // namespace

MeshFile ReadTetgen(const std::filesystem::path& file, double unit) {
  std::filesystem::path nodes = file, elements = file;
  RowReader node_rows(nodes.replace_extension(".node"));
  RowReader element_rows(elements.replace_extension(".ele"));
  MeshBuilder builder(node_rows);
  ReadNodeTable(&node_rows, &builder);
  RequireEnd(&node_rows);
  builder.set_place(element_rows);
  ReadElementTable(&element_rows, &builder);
  RequireEnd(&element_rows);
  return builder.Finish(unit);
}

}  // namespace palpate
