// What a study asks of every model alike: presses of the scene's tool, where the tool would meet
// the object. Frame O.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"

namespace palpate::study {

// The tool goes straight in at one place, as a rigid patch or, if loaded, as an even pressure over
// its true area, which is the same on every mesh. Asked for is the force that the depth takes; of a
// loaded press at the ratio of load and mean displacement (the secant).
struct Press {
  Eigen::Vector3d p_O{0, 0, 0};       // centre of the patch at rest [m]
  Eigen::Vector3d inward_O{0, 0, 0};  // unit vector
  Eigen::Vector3d along_O{0, 0, 0};   // unit tangent: the way a moved contact goes
  bool loaded = false;                // by an even pressure
};

inline constexpr std::size_t kMany = 3;  // presses, which are a sample of how meshes lie under them

struct PressSpec {
  std::vector<Press> presses;  // one or more, each on its own
  double width = 0;            // of the tool [m], > 0
  double depth = 0;            // as deep as the operator goes, at most half the size [m]
  double small_depth = 0;      // where every model is linear [m]
  double load = 0;  // of loaded presses, reaches about `depth` [N]; at the small depth its share
  double size = 0;  // larger side of the bounding box, the radius of a membrane [m]
};

// The scene's own question. Planar objects: at the boundary nearest to the tool's home; membranes:
// at the centre and at half the radius; volumes: loaded, on the surface opposite to what is held
// (the whole nodes under a rigid disc differ so much from mesh to mesh that no solution converges).
// `places` [m] are taken instead, where given, each moved to the surface, and pressed by a rigid
// tool as the slave's; without them those of the scene. A scene without a tool gets one as wide as
// a fifteenth of the object. Throws std::invalid_argument: an outline that only an image knows, a
// place off the object.
PressSpec AskedOf(const Scene& scene, const std::vector<Eigen::Vector3d>& places = {});

// A uniform load over a disc on a triangulated surface, the same on every mesh: no whole triangles,
// no whole nodes.
struct LoadPoint {
  Eigen::Vector3d p_O{0, 0, 0};  // on the triangle [m]
  int triangle = -1;
  double share = 0;  // of the load; all of them sum up to 1
};

// Points whose loads do the work of a load spread evenly over all that lies within width / 2 of
// `p_O` and faces against `inward_O` (within 60 degrees, so that a thin object is pushed on one
// side). Exact where the displacement is linear within a triangle, but for the edge of the disc,
// which is cut out in steps of a 64th of the triangles' edges; with `quadratic` also where it is a
// parabola: then the points are the six nodes, and some shares are negative. Empty: nothing lies
// there.
std::vector<LoadPoint> RoundLoad(const SurfaceMesh& surface, const Eigen::Vector3d& p_O,
                                 const Eigen::Vector3d& inward_O, double width, bool quadratic);

}  // namespace palpate::study
