// A plate's load from points with outliers and a moved rim: iteratively reweighted least squares
// around LoadFitter, with nuisance parameters that Wald tests decide about.
//
//   z_i = w(x_i; place, force) + c0 + c1 x + c2 y + noise       along z; c: motion of the rim
//   (x, y)_i - (x, y)_i at rest = slide + growth (x_i - mean x) + noise     along the plate
//
// c is zero (Rim::kStays) unless the residuals or the slide of the points contradict that.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "slave/checks/load/fit_sample.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// The same plate with a larger tension at rest, by `more` [N/m]. nullptr: there is none.
struct TighterPlate {
  PlateSurface* plate = nullptr;
  double more = 0;
};

// Used by one thread. Allocation-free after the first call with as many points.
class RobustPlateFit {
 public:
  // Stores references to the plates; see LoadFitter. `tighter`: the same plate with more tension;
  // the result states which part of the additional tension fits the points.
  RobustPlateFit(PlateSurface& plate, const PlateSurface::Tool& tool, PlateSurface* finer = nullptr,
                 TighterPlate tighter = {});

  // Points in frame O, of which PlateLimits::kMaxPoints are used; invisible points, points off the
  // plate, not finite or without a sigma do not count. A point more than five standard deviations
  // (of the points' scatter) and a share of the largest deflection from the fit is an outlier and
  // excluded. A point is used at its position at rest, also if it moved sideways.
  PlateFit Fit(const std::vector<SurfacePoint>& points_O) noexcept;
  void Reset() noexcept {
    fitter_.Reset();
    rest_frames_ = 0;
  }
  // The plate of the last result, and its solution: of one contact, the load.
  [[nodiscard]] PlateSurface& answered() noexcept { return fitter_.answered(); }
  [[nodiscard]] const Solution& solution() const { return fitter_.solution(); }

 private:
  void Read(const std::vector<SurfacePoint>& points_O);
  PlateFit FitRim(double slide) noexcept;
  PlateFit FitLoad(Rim rim, const Eigen::Vector3d& offset) noexcept;
  LoadFit SolveWeighted(Rim rim, bool is_last) noexcept;
  void SetWeights(bool is_last) noexcept;
  bool FindOutliers(const LoadFit& load, Rim rim) noexcept;
  void LearnRim(const PlateFit& fit, bool slid) noexcept;
  [[nodiscard]] double SigmaOfMean(const LoadFit& load) const noexcept;
  [[nodiscard]] bool RimMoved(const LoadFit& load) const noexcept;
  [[nodiscard]] bool Explains(const PlateFit& fit) const noexcept;
  [[nodiscard]] double Slide() noexcept;
  [[nodiscard]] NuisanceParameter Growth(const LoadFit& load) const noexcept;
  void EstimateTension(PlateFit* fit) noexcept;

  struct Row {
    Eigen::Vector2d place{0, 0};        // at rest, frame O [m]
    Eigen::Vector3d moved{0, 0, 0};     // since [m]
    double sigma = 1, sigma_along = 0;  // along z, along the plate [m]
    double offset = 0, residual = 0;    // of a moved rim, of the fit, along z [m]
    double weight = 0;                  // square root of the weight of the squared residual
    bool usable = false, kept = false;
  };
  PlateSurface& plate_;
  TighterPlate tighter_;
  PlateSurface::Tool tool_;
  LoadFitter fitter_;
  Solution coarse_, tight_;           // of plate_ and tighter_ under the same load
  std::vector<std::size_t> visible_;  // indices of usable points
  std::vector<Row> rows_;
  int usable_ = 0, kept_ = 0;
  // Motion of the rim since the baseline, as the mean over images without a load since the points
  // last slid. A moving rim bends the plate like a load, so fitting it in every image would absorb
  // a part of the force.
  Eigen::Vector3d rim_motion_{0, 0, 0};
  int rest_frames_ = 0;    // number of such images
  bool used_rim_ = false;  // whether the last fit kept the rim there
  double deepest_ = 0;     // of the fitted points [m]
  double scatter_ = 1;     // scatter of residuals / sigma
  std::vector<Eigen::Vector2d> places_;
  std::vector<double> displacements_, sigmas_, sorted_;
};

}  // namespace palpate
