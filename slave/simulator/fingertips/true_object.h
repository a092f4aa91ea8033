// The true object of a scene with fingertips: material, fixed parts, the fingers around it, and
// meshes that are fine near the contacts.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "slave/simulator/fingertips/finger_hand.h"
#include "slave/simulator/fingertips/pressed_body.h"
#include "slave/simulator/fingertips/site_mesh.h"

namespace palpate::simulation {

// An intersection of a straight line with a closed surface.
struct RayHit {
  double distance = 0;           // along the ray [m]
  Eigen::Vector3d n_O{0, 0, 0};  // outward unit normal of the triangle
};

// The first crossing ahead of `p_O` along the unit vector `direction_O`. O(N).
std::optional<RayHit> FirstHit(const SurfaceMesh& surface, const Eigen::Vector3d& p_O,
                               const Eigen::Vector3d& direction_O);

// Returns whether a point is inside a closed surface: any ray from it crosses the surface an odd
// number of times.
bool IsInside(const SurfaceMesh& surface, const Eigen::Vector3d& p_O);

// The body at rest as one mesh. Frame O.
struct RestBody {
  SiteMesh mesh;
  PressedBody::Held held;
  SurfaceMesh surface;                       // of the mesh, its own nodes only
  std::vector<int> node_of;                  // surface node to node of the mesh
  std::vector<Eigen::Vector3d> touchable_O;  // nodes of the surface that fingers can meet [m]
};

class TrueObject {
 public:
  // Throws std::invalid_argument naming the key: an object that is not a volume or has no fixed
  // part, a fingertip inside it, a Poisson's ratio for which elements lock.
  TrueObject(const Scene& scene, const SiteResolution& resolution);
  static constexpr double kMaxPoisson = 0.49;

  [[nodiscard]] const Eigen::Isometry3d& X_SO() const { return X_SO_; }  // misplacement included
  [[nodiscard]] const FingerHand& hand() const { return hand_; }
  [[nodiscard]] const Object& object() const { return scene_.object; }
  [[nodiscard]] const Material& material() const { return scene_.object.material; }
  // Mesh for contacts with the offset `lateral_O` from the approach: boxes are fine there, with the
  // same triangles everywhere; mesh files are the same everywhere.
  [[nodiscard]] std::shared_ptr<const RestBody> BodyFor(const Eigen::Vector3d& lateral_O) const;

 private:
  void CountHexahedra(const BoxGeometry& box);
  void CheckHome() const;
  [[nodiscard]] std::vector<Eigen::Vector3d> Focuses(const Eigen::Vector3d& lateral_O) const;
  [[nodiscard]] std::array<std::vector<double>, 3> GradedAxes(
      const BoxGeometry& box, const Eigen::Vector3d& lateral_O) const;
  [[nodiscard]] std::shared_ptr<const RestBody> Finish(SiteMesh mesh) const;

  Scene scene_;
  SiteResolution resolution_;
  Eigen::Isometry3d X_SO_;
  FingerHand hand_;
  SurfaceMesh plain_;               // the surface as in the scene
  std::array<int, 3> hexahedra_{};  // of a box; zero: not counted yet
  std::shared_ptr<const RestBody> file_body_;
};

}  // namespace palpate::simulation
