// A cube between two fingers, as a slave might report it: displacements made up, not computed.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "master/link/remote_mesh.h"
#include "master/session/session.h"

namespace palpate {

// The deformed object and the forces of the fingertips at one moment.
struct ShapeMoment {
  std::shared_ptr<const RemoteMesh> mesh;
  std::vector<NamedFinger> fingers;
};

inline constexpr double kCubeSide = 0.06;  // [m], lower corner at the origin of S

// A cube pressed `depth` [m] deep at the centres of the faces x = 0 and x = side, with dents 12 mm
// wide, rotated about z by `turn` [rad].
inline ShapeMoment PinchedCube(double depth, double turn = 0) {
  const SolidMesh solid = MeshBox({kCubeSide, kCubeSide, kCubeSide}, {6, 6, 6});
  const Eigen::Matrix3d R = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  auto topology = std::make_shared<MeshTopology>();
  topology->surface = SurfaceOf(solid);
  RemoteMesh mesh;
  mesh.validity = Validity::kValid;
  const Eigen::Vector3d left(0, kCubeSide / 2, kCubeSide / 2);
  const Eigen::Vector3d right(kCubeSide, kCubeSide / 2, kCubeSide / 2);
  for (Eigen::Vector3d& node : topology->surface.nodes) {
    const auto indentation = [&](const Eigen::Vector3d& at) {
      return depth * std::exp(-(node - at).squaredNorm() / (2 * 0.012 * 0.012));
    };
    mesh.positions.push_back(
        R * (node + Eigen::Vector3d(indentation(left) - indentation(right), 0, 0)));
    node = R * node;
  }
  mesh.topology = topology;
  FingerState first, second;
  first.p_S_contact = (R * left).cast<float>();
  first.force = (R * Eigen::Vector3d(-0.42, 0, 0.05)).cast<float>();
  first.in_contact = true;
  first.validity = Validity::kValid;
  second = first;
  second.p_S_contact = (R * right).cast<float>();
  second.force = (R * Eigen::Vector3d(0.40, 0, 0.03)).cast<float>();
  ShapeMoment moment;
  moment.mesh = std::make_shared<const RemoteMesh>(std::move(mesh));
  moment.fingers = {{"ff", first}, {"th", second}};
  return moment;
}

}  // namespace palpate
