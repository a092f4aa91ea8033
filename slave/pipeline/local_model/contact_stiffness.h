// Stiffness of an object under a fingertip, for the local contact model that the master renders.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"

namespace palpate {

struct Contact;

// Half-space stiffness of a bonded rigid disc of `radius` a [m]: along the normal
// 2 E a / (1 - nu^2), across it 32 (1 - nu) G a / (7 - 8 nu) with G = E / (2 (1 + nu)). Johnson,
// Contact Mechanics (1985), 3.4 and 7.2; Gazetas (1983).
Eigen::Matrix3d DiscStiffness(const Material& material, double radius,
                              const Eigen::Vector3d& n) noexcept;

// The rigid disc with the same force as a sphere of radius R at indentation d (Hertz), F = 4/3 E*
// R^1/2 d^3/2: a = 2/3 (R d)^1/2 [m].
double DiscOfSphere(double sphere_radius, double depth) noexcept;

// The scene's elements determine the compliance of the whole body under patches of nodes that they
// resolve, by Green's functions (fem-green) of the surface nodes. The additional compliance of a
// fingertip's smaller contact is that of a half-space:
//
//   K^-1 = K_mesh(a_patch)^-1 + K_disc(a)^-1 - K_disc(a_patch)^-1.
//
// If the mesh cannot be used (on supports, a body without fixed nodes, a surface without a volume,
// nu near 1/2), only the half-space is used. Small strain. Nodes are computed at their first
// request and stored; for small meshes in advance. Not thread-safe.
//
// Other fingers press at the same time and resist the motion of this one, or move with it: K_mesh
// is the force of a patch per displacement u while the others are displaced by s u.
class ContactStiffness {
 public:
  // The patch of another finger.
  struct Companion {
    int triangle = -1;
    Eigen::Vector3d p_O{0, 0, 0};
    double sense = 1;  // s: 1 along, -1 opposite
  };

  // `solid` null: half-space only.
  ContactStiffness(const Scene& scene, const SurfaceMesh& surface, const SolidMesh* solid,
                   std::vector<Companion> companions = {});
  ~ContactStiffness();

  // Stiffness of a disc of `radius` [m] at the point of `triangle` with barycentric `weights`,
  // frame O [N/m]; symmetric, positive definite. Allocation-free where the triangle's nodes are
  // known.
  [[nodiscard]] Eigen::Matrix3d At(int triangle, const Eigen::Vector3d& weights, double radius);
  // Returns whether At can answer for this triangle without computing nodes.
  [[nodiscard]] bool Knows(int triangle) const;

 private:
  struct Greens;
  struct NodeCompliance {
    Eigen::Matrix3d C_O = Eigen::Matrix3d::Zero();  // of the patch [m/N]
    double patch_radius = 0;                        // [m]; 0: unknown
    bool asked = false;
  };
  const NodeCompliance& Node(int node);
  [[nodiscard]] std::optional<Eigen::Matrix3d> Alone(const Contact& contact) const;
  [[nodiscard]] std::optional<Eigen::Matrix3d> Together(const Contact& contact) const;

  Object object_;
  SurfaceMesh surface_;
  std::vector<double> node_area_;  // of the surface, a third of each triangle's [m^2]
  double patch_width_ = 0;         // [m]
  std::unique_ptr<Greens> greens_;
  std::vector<Companion> companions_;
  std::vector<NodeCompliance> nodes_;
};

}  // namespace palpate
