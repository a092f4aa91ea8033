// Where a fingertip's electrodes sit on its rigid core.
#pragma once

#include <array>
#include <filesystem>

#include <Eigen/Core>

#include "slave/capture/tactile_frame.h"

namespace palpate {

// Frame F (see Finger): axis x, tip at +x, pad towards -z, origin at the centre of the tip's
// sphere.
struct ElectrodeLayout {
  std::array<Eigen::Vector3d, kElectrodeCount> p_F;  // [m]
  std::array<Eigen::Vector3d, kElectrodeCount> n_F;  // outward unit normals
};

// Rows `NAME,x,y,z,nx,ny,nz` in millimetres, names E1 to E19 in any order; # comments; other names
// are ignored. Throws std::runtime_error `file:line: ...`.
ElectrodeLayout ReadElectrodeLayout(const std::filesystem::path& file);

// The simulated fingertip's: nineteen electrodes in an arrangement of our own under a skin of
// `radius` [m].
ElectrodeLayout SimulatedLayout(double radius);

}  // namespace palpate
