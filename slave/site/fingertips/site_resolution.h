// How fine the true body's mesh is.
#pragma once

#include <cstddef>

namespace palpate {

struct SiteResolution {
  double edge = 1e-3;             // between the nodes of boxes, where fingers touch [m]
  double fine_reach = 2e-3;       // as near so far from there [m]
  double growth = 0.6;            // of that per distance beyond [-]
  int most_hexahedra = 225;       // of a box; above them all edges are made longer
  std::size_t most_tets = 20000;  // mesh files are refined, at most twice, within this
};

}  // namespace palpate
