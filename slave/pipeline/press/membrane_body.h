// An air-filled membrane under the cameras: the body of a SurfaceEstimator.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/checks/load/fit_sample.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/membrane/inflated_membrane.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/press/membrane_press.h"

namespace palpate {

// The enclosed air responds to the press (InflatedMembrane::Params::air_stiffness), so no pressure
// sensor is needed. Loads are uniform pressures on the tool's round patch; pulling loads are
// excluded.
class MembraneBody final : public LoadIdentifier {
 public:
  // `patch`: diameter of the tool's contact [m], > 0; indentations deeper than half of it rotate
  // the surface beyond the range of the linear model and are extrapolated. Throws
  // std::invalid_argument naming the parameter. `rest`: surface on which points at rest must lie,
  // if it is known.
  MembraneBody(InflatedMembrane membrane, double patch, const std::optional<Ellipsoid>& rest = {});

  SurfaceLoad Fit(const std::vector<SurfacePoint>& points_O) noexcept override;
  Press PressAt(const Eigen::Vector3d& p_O, double depth) noexcept override;
  void Nearest(const Eigen::Vector3d& p_O_tip, Eigen::Vector3d* p_O,
               Eigen::Vector3d* n_O) const noexcept override;
  [[nodiscard]] const SurfaceMesh& surface() const override { return press_.membrane().surface(); }
  void Displacements(std::vector<Eigen::Vector3d>* u_O) override;
  void NodalForces(std::vector<Eigen::Vector3d>* f_O) override;
  void Reset() override { load_ = {}; }
  [[nodiscard]] const ModelInfo& info() const override { return info_; }

 private:
  ModelInfo info_;
  MembranePress press_;
  SurfaceContact contact_;
  double patch_;
  Checks<FitSample> checks_;
  SurfaceLoad load_;
};

// The membrane of a scene with a DomeGeometry and a tool: E h from its modulus and thickness,
// tension from `model.prestress`, the pressure that balances it, and air that is compressed at
// constant temperature. Triangles are a third of the tool's width. Throws std::invalid_argument
// naming the key.
std::unique_ptr<LoadIdentifier> MakeMembraneBody(const Scene& scene);

}  // namespace palpate
