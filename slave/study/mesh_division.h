// The meshes of a volume on which a study tries its models.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "slave/scene/scene.h"

namespace palpate::study {

struct Division {
  Scene scene;              // cut into these cells, or refined as often
  std::string resolution;   // for people: "6 x 6 x 6 cells"
  double element_size = 0;  // [m]
  bool own = false;         // the scene's own
  bool between = false;     // for models that cannot afford the next one, to see their convergence
  std::size_t nodes = 0, tets = 0;  // expected
  double presses = 1;               // number of presses that each model answers
};

// Coarser and finer cells of a box, refinements of other volumes (and of a box that is fixed by
// node numbers), the latter with fewer than about `max_dof` unknowns.
std::vector<Division> DivisionsOf(const Scene& scene, std::size_t max_dof);

}  // namespace palpate::study
