// Finds the load that explains measured points of a surface by the object's model.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/checks/load/surface_load.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// The part that SetModel replaces as a whole: the model and the fit through it.
class LoadIdentifier : public PreparedModel {
 public:
  LoadIdentifier() = default;
  LoadIdentifier(const LoadIdentifier&) = delete;
  LoadIdentifier& operator=(const LoadIdentifier&) = delete;
  // Never throws; allocation-free after the first call with as many points, for large volumes once
  // the nodes around the load are known. Points in frame O. If no load exceeds the noise, the force
  // is 0 with its sigma, kValid.
  virtual SurfaceLoad Fit(const std::vector<SurfacePoint>& points_O) noexcept = 0;
  // Normal stiffness at the surface point p_O [N/m] and force [N] of the scene's tool at
  // indentation `depth` [m], according to the model, for the local contact model. Never throws.
  struct Press {
    double force = 0, stiffness = 0;  // size of the force, d force / d depth
    bool valid = false;
  };
  virtual Press PressAt(const Eigen::Vector3d& p_O, double depth) noexcept = 0;
  // Nearest point of the surface at rest and its outward normal.
  virtual void Nearest(const Eigen::Vector3d& p_O_tip, Eigen::Vector3d* p_O,
                       Eigen::Vector3d* n_O) const noexcept = 0;
  [[nodiscard]] virtual const SurfaceMesh& surface() const = 0;  // at rest, frame O
  // Displacements of the nodes of surface(), under the load last fitted [m]; and the load as forces
  // on them [N].
  virtual void Displacements(std::vector<Eigen::Vector3d>* u_O) = 0;
  virtual void NodalForces(std::vector<Eigen::Vector3d>* f_O) = 0;
  virtual void Reset() = 0;
  // Reuses results of `before`, which this object replaces, if they are the same here. May throw
  // std::bad_alloc.
  virtual void TakeOver(LoadIdentifier* /*before*/) {}
};

// plate and plate-large for flat membranes, membrane for domed ones; fem and
// fem-green for volumes. Throws std::invalid_argument naming the key; Interrupted,
// if `progress` requests a stop.
std::unique_ptr<LoadIdentifier> MakeLoadIdentifier(const Scene& scene,
                                                   Progress* progress = nullptr);

// A load over a disc as forces on the nodes of a surface. Spreads `force_O` [N] evenly over the
// disc of diameter `width` [m], 0: a point, around the surface point p_O with normal n_O: each
// point of the disc is distributed to the nodes of its triangle, which preserves force and centre.
// The forces are `f_O`, one per node. O(nodes).
void SpreadLoad(const SurfaceMesh& surface, const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O,
                double width, const Eigen::Vector3d& force_O, std::vector<Eigen::Vector3d>* f_O);

// Volumes in front of cameras: `fem`, `fem-green`. One load along the surface normal, by least
// squares in all three components of all visible points. Its position is searched over all nodes of
// the surface, then within the triangles there, where three nodal forces of one sign, a linear
// problem, form one load between the nodes. The search uses the body's Green's functions at rest;
// for a nonlinear model the force is refined with the model itself. Each point needs three
// solutions. Until all visible points have them, which may take many observations of a large body,
// the load is unknown (kFailed). `width`: diameter of the load [m]. Throws std::invalid_argument
// naming the key: not a volume, a dynamic model; see MeshObject, MakeModel.
std::unique_ptr<LoadIdentifier> MakeVolumeLoadIdentifier(const Scene& scene, double width,
                                                         Progress* progress);

}  // namespace palpate
