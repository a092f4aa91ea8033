// The tables of TetGen's .node and .ele files, which Vega's .veg files hold too.
#pragma once

#include <string>

#include "shared/mesh/files/mesh_builder.h"
#include "shared/mesh/files/row_reader.h"

namespace palpate {

// `count 3 attributes markers`, then `number x y z ...` per node; numbers rise by one from 0 or 1.
void ReadNodeTable(RowReader* rows, MeshBuilder* builder);
// `count corners attributes`, then `number corners ...` per tetrahedron of 4 or 10 nodes.
void ReadElementTable(RowReader* rows, MeshBuilder* builder);

}  // namespace palpate
