// The contacts that a study computes with every model: those of the scene's tool, where it would
// first touch the object. Frame O.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate::study {

// The tool moves straight in at one point, as a rigid contact or, if loaded, as a uniform pressure
// over its true area, which is the same on every mesh. The result is the force at the depth; for a
// loaded contact at the ratio of load and mean displacement (the secant).
struct Press {
  Eigen::Vector3d p_O{0, 0, 0};       // centre of the patch at rest [m]
  Eigen::Vector3d inward_O{0, 0, 0};  // unit vector
  Eigen::Vector3d along_O{0, 0, 0};   // unit tangent: direction of a moved contact
  bool loaded = false;                // loaded by a uniform pressure
};

inline constexpr std::size_t kMany =
    3;  // contacts, a sample of possible positions relative to the mesh

// SeenPress is a press of a membrane as its cameras measure it: the slave estimates the force from
// the displaced points, not from the depth of the tool.
struct SeenPress {
  double force = 0;  // along the press at full depth [N]
  // From rest to full depth; without noise, each point with its covariance.
  std::vector<std::vector<SurfacePoint>> images_O;
};

struct PressSpec {
  std::vector<Press> presses;   // one or more, each on its own
  std::vector<SeenPress> seen;  // one per press; empty: the model's answers for the depth are used
  double width = 0;             // of the tool [m], > 0
  double depth = 0;             // indentation of the operator, at most half the size [m]
  // Of membranes: the depth at which every model is linear [m]. Else, and with cameras: `depth`,
  // because the contact of a tool may grow with it.
  double small_depth = 0;
  // For loaded contacts the load that reaches about `depth` [N]; reduced in proportion at the small
  // depth.
  double load = 0;
  double size = 0;  // larger side of the bounding box, the radius of a membrane [m]
};

// The scene's own contacts. Planar objects: at the boundary nearest to the tool's home. Membranes:
// under home. Volumes: on the surface opposite to the fixed part; loaded where VolumeForce does
// not apply (a rigid disc on whole nodes differs so much from mesh to mesh that no solution
// converges; a round tool is never loaded). If given, `places` [m] are used instead, each moved to
// the surface, with a rigid tool; without them those of the scene. A scene without a tool gets one
// as wide as a fifteenth of the object. Throws std::invalid_argument: an outline that needs an
// image, a point off the object.
PressSpec AskedOf(const Scene& scene, const std::vector<Eigen::Vector3d>& places = {});

// A uniform load over a disc on a triangulated surface, the same on every mesh: no whole triangles,
// no whole nodes.
struct LoadPoint {
  Eigen::Vector3d p_O{0, 0, 0};  // on the triangle [m]
  int triangle = -1;
  double share = 0;  // of the load; all of them sum up to 1
};

// Returns point loads that are equivalent to a uniform load on the surface within width / 2 of
// `p_O` that faces against `inward_O` (within 60 degrees, so that a thin object is pushed on one
// side). They are exact for displacements that are linear within a triangle, except at the edge of
// the disc, which is resolved in steps of a 64th of the triangles' edges; with `quadratic` also for
// quadratic displacements: then the points are the six nodes, and some shares are negative. Empty:
// there is no such surface.
std::vector<LoadPoint> RoundLoad(const SurfaceMesh& surface, const Eigen::Vector3d& p_O,
                                 const Eigen::Vector3d& inward_O, double width, bool quadratic);

}  // namespace palpate::study
