// The rotation of a deformation gradient, for eight elements at a time.
//
//   R = argmax over SO(3) of tr(R^T F), the polar rotation with det R = +1, also for inverted
//   elements.
//
// Newton's method on the rotation vector: w = axial(S - S^T), H = tr(S) I - sym(S), S = R^T F, R <-
// R exp([H^-1 w]). A stationary rotation with H > 0 is the only maximum (of the four stationary
// quaternions just one is), so the solution can be verified. The unit quaternion (s, v) and E = S -
// I are stored, so that tiny strains keep all digits.
#pragma once

#include <array>

#include <Eigen/Core>

#include "slave/mechanics/linear/lanes.h"

namespace palpate::fem {

struct LaneQuaternion {
  Double8 s, x, y, z;
};

// Computes the rotation of one element for any F without a start value: Davenport's eigenvector.
// Returns s, x, y, z.
Eigen::Vector4d SignedPolarQuaternion(const Eigen::Matrix3d& F) noexcept;

// R - I of a unit quaternion.
PALPATE_INLINE Lanes3x3 RotationMinusIdentity(const LaneQuaternion& q) {
  const Double8 xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const Double8 xy = q.x * q.y, yz = q.y * q.z, zx = q.z * q.x;
  const Double8 sx = q.s * q.x, sy = q.s * q.y, sz = q.s * q.z;
  return {{{-2 * (yy + zz), 2 * (xy - sz), 2 * (zx + sy)},
           {2 * (xy + sz), -2 * (zz + xx), 2 * (yz - sx)},
           {2 * (zx - sy), 2 * (yz + sx), -2 * (xx + yy)}}};
}

// E = R^T F - I = G + Q^T + Q^T G with G = F - I, Q = R - I.
PALPATE_INLINE Lanes3x3 StretchMinusIdentity(const Lanes3x3& Q, const Lanes3x3& G) {
  Lanes3x3 E;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      E[i][j] = G[i][j] + Q[j][i] + (Q[0][i] * G[0][j] + Q[1][i] * G[1][j] + Q[2][i] * G[2][j]);
    }
  }
  return E;
}

}  // namespace palpate::fem
