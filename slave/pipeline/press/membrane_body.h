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

// The membrane's own air answers the press (InflatedMembrane::Params::air_stiffness): no pressure
// sensor is read. Loads are even pressures on the tool's round patch; what pulls is no load.
class MembraneBody final : public LoadIdentifier {
 public:
  // `patch`: diameter of the tool's contact [m], > 0; indentations deeper than half of it turn the
  // surface by more than the linear model counts and are extrapolated. Throws std::invalid_argument
  // naming the parameter. `rest`: points at rest must lie on it, where it is known.
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
// tension from `model.prestress`, pressure as balances it, the enclosed air pressed together at its
// temperature. Triangles are a third of the tool's width. Throws std::invalid_argument naming the
// key.
std::unique_ptr<LoadIdentifier> MakeMembraneBody(const Scene& scene);

}  // namespace palpate
