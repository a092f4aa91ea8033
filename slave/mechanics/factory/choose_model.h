// The model of `model.kind: auto`: a table of rules that reads only the scene, so that every
// machine chooses the same. `palpate-slave study` measures the trade; the constants were fitted to
// it on 72 drawn scenes and tried on others (deploy/guides/speed-and-accuracy.md).
//
// | object | condition | model |
// |---|---|---|
// | outline | known only from the image, or no tool | bem2d, elements as in the scene |
// | outline | the plane model's error is beyond the tolerance, and extruded applies | extruded |
// | outline | else | bem2d; as many elements under the tool as the tolerance needs |
// | flat membrane | no tension, the bending plate's error within the tolerance | plate |
// | flat membrane | else | plate-large |
// | domed membrane | | membrane |
// | volume | motion, weight, friction, other tools, or large strains by the scene's law | fem |
// | volume | pressed deeper than the tolerance allows a linear model | fem, neo-hookean |
// | volume | else | fem-green |
//
// `fem` gets ten-node tetrahedra from the Poisson's ratio on at which four-node ones lock;
// `fem-green` gets them unless they would be too many. Boxes get as many cells, and mesh files as
// many refinements, as the tolerance needs under the tool.
#pragma once

#include <array>
#include <string>

#include "slave/scene/scene.h"

namespace palpate {

struct ModelChoice {
  ModelOptions model;          // its kind is never `auto`
  std::array<int, 3> cells{};  // of a box; zeros: another object
  std::string reason;          // one sentence
};

// The model of a scene whose kind is `auto`; otherwise that of the scene. Reads the mesh file of a
// volume. Throws std::invalid_argument: see MeshObject.
ModelChoice ChooseModel(const Scene& scene);
// The scene with that model in the place of `auto`.
Scene WithChosenModel(Scene scene);

}  // namespace palpate
