// Clamped round membranes in front of cameras: `plate` and `plate-large`.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slave/checks/load/fit_sample.h"
#include "slave/mechanics/plate/fit/press_table.h"
#include "slave/mechanics/plate/plate_surface.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/load/robust_plate_fit.h"

namespace palpate {

// Frame O: origin at the membrane's centre, z along the outward normal. The points are on a face of
// the membrane; their displacement along z is that of the plate at their position at rest.
//
// Error of the plate's law, compared with a neo-Hookean solid (1 mm of rubber, radius 39 mm, tool 4
// mm, 0.5 to 5 mm deep, up to 0.7 of the radius): von Karman's force from the 31 dots is within 2.7
// %, but at equal depth of the tool it is too high by up to 13 %. So a press that is known only by
// its depth, PressAt, is less accurate than one measured by the dots. Thinner sheets (0.5 mm):
// within 4 %; thicker ones: 2 mm within 3 % up to half the radius, 6 % at 0.7 of it; 3.9 mm 6 % at
// the centre, and much more beside it, which is flagged. The force's sigma includes this error:
// plate::LawsSigma.
class PlateLoadIdentifier final : public LoadIdentifier {
 public:
  // `tool`: the pressing tool. Throws std::invalid_argument, std::runtime_error: see LoadFitter,
  // PressTable. `finer`: the same plate with more modes for loads that `plate` does not resolve,
  // nullptr: none. `tighter`: the same at `more` tension [N/m], to check the scene's tension at
  // rest; nullptr: no check. `prestress` [N/m]: of `plate`.
  PlateLoadIdentifier(std::unique_ptr<PlateSurface> plate, const PlateSurface::Tool& tool,
                      std::unique_ptr<PlateSurface> finer = nullptr,
                      std::unique_ptr<PlateSurface> tighter = nullptr, double more = 0,
                      double prestress = 0);

  SurfaceLoad Fit(const std::vector<SurfacePoint>& points_O) noexcept override;
  // Returns the press, which depends only on the radius; beyond 0.9 of the radius it is that at
  // 0.9.
  Press PressAt(const Eigen::Vector3d& p_O, double depth) noexcept override;
  void Nearest(const Eigen::Vector3d& p_O_tip, Eigen::Vector3d* p_O,
               Eigen::Vector3d* n_O) const noexcept override;
  // The nodes of MembraneGrid().
  [[nodiscard]] const SurfaceMesh& surface() const override { return surface_; }
  void Displacements(std::vector<Eigen::Vector3d>* u_O) override;
  void NodalForces(std::vector<Eigen::Vector3d>* f_O) override;
  void Reset() override;
  [[nodiscard]] const ModelInfo& info() const override { return plate_->info(); }

 private:
  void SetLoad(const FitSample& sample) noexcept;
  [[nodiscard]] double LawsShare(const SurfaceLoad& load) const noexcept;
  [[nodiscard]] static double ScatterOf(const FitSample& sample) noexcept;
  [[nodiscard]] double SigmaAtRest(const std::vector<SurfacePoint>& points_O) const noexcept;

  std::unique_ptr<PlateSurface> plate_, finer_, tighter_;
  PlateSurface::Tool tool_;
  PressTable table_;
  RobustPlateFit fit_;
  SurfaceMesh surface_;
  SurfaceLoad load_;  // the last one
  Checks<FitSample> checks_;
  double rest_square_ = 0;  // mean squared residual without contact, in sigmas; 0: unknown
};

}  // namespace palpate
