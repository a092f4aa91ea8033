// A fingertip's shape, and where its electrodes sit.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/capture/tactile_frame.h"

namespace palpate {

// The finger model: a half sphere at the tip, a cylinder behind it (paper B, equation 4). Frame F.
struct FingerSurface {
  double radius = 7e-3;  // [m]
  // The point of the surface outward of `c_F`: from the origin where c_x >= 0, from the axis at c_x
  // behind it. nullopt: `c_F` is the origin, or on the axis, or not finite.
  [[nodiscard]] std::optional<Eigen::Vector3d> Project(const Eigen::Vector3d& c_F) const noexcept;
  // Returns the outward unit normal at a point of the surface.
  [[nodiscard]] Eigen::Vector3d Normal(const Eigen::Vector3d& p_F) const noexcept;
};

// Positions of a fingertip's electrodes on its rigid core, or of another sensor's channels on its
// surface. Frame F (see Finger): axis x, tip at +x, pad towards -z, origin at the centre of the
// tip's sphere.
struct ElectrodeLayout {
  explicit ElectrodeLayout(int channels = kElectrodeCount)
      : p_F(static_cast<std::size_t>(channels)), n_F(p_F.size()) {}
  std::vector<Eigen::Vector3d> p_F;  // [m]
  std::vector<Eigen::Vector3d> n_F;  // outward unit normals
};

// Rows `NAME,x,y,z,nx,ny,nz` in millimetres, names E1 to E19 (or c1 to cN) in any order; #
// comments; other names are ignored. Throws std::runtime_error `file:line: ...`.
ElectrodeLayout ReadElectrodeLayout(const std::filesystem::path& file,
                                    const TactileChannels& channels = {});

// Layout of the simulated fingertip: nineteen electrodes in our own arrangement under a skin of
// `radius` [m].
ElectrodeLayout SimulatedLayout(double radius);

}  // namespace palpate
