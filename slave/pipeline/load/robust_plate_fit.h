// A plate's load from points with outliers and a moved frame: the robust part around the least
// squares of LoadFitter.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/checks/load/plate_fit.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// A subset of points, spread evenly over a round plate: the cost of a fit grows with their number,
// its accuracy hardly does beyond some density. One thread; allocation-free after the first call
// with as many points.
class GridSubsample {
 public:
  static constexpr int kNone = -1;  // index of a square without a visible point [by definition]

  // `radius` of the plate about the origin of O [m].
  explicit GridSubsample(double radius) : radius_(radius) {}

  // Indices of points on the plate, frame O. With more than PlateLimits::kMostPoints: for each
  // square of a grid the visible point nearest to its middle, or kNone; their number depends only
  // on the positions at rest.
  const std::vector<int>& Of(const std::vector<SurfacePoint>& points_O);

 private:
  struct Square {
    bool has_points = false;
    int nearest = kNone;
    double distance = 0;  // from the middle [squares], squared
  };
  void Add(const SurfacePoint& point, int index);

  double radius_;
  std::vector<int> chosen_;
  std::vector<Square> squares_;
};

// A plate at `more` tension at rest than another one [N/m]; nullptr: there is none.
struct TighterPlate {
  PlateSurface* plate = nullptr;
  double more = 0;
};

// One thread; allocation-free after the first call with as many points.
class RobustPlateFit {
 public:
  // Keeps references to the plates; see LoadFitter. `tighter`: the result states how much of that
  // tension fits the points.
  RobustPlateFit(PlateSurface& plate, double width, PlateSurface* finer = nullptr,
                 TighterPlate tighter = {})
      : plate_(plate),
        tighter_(tighter),
        width_(width),
        fitter_(plate, width, finer),
        choice_(plate.radius()) {
    // Room for the solutions, before the first fit: a fit does not allocate.
    const Contact none = PlateSurface::DiscContact(Contact::Kind::kForce, {0, 0}, width, 0);
    plate.Solve({&none, 1}, &coarse_);
    if (tighter.plate != nullptr) tighter.plate->Solve({&none, 1}, &tight_);
  }

  using Answer = PlateFit;
  // Points in frame O, of which a subset is used; invisible points, points off the plate, not
  // finite or without a sigma do not count. A point more than five standard deviations (of the
  // points' scatter) and a twentieth of the largest deflection from the fit is excluded, and the
  // load is fitted again. A point is used at its position at rest, also if it moved sideways.
  Answer Fit(const std::vector<SurfacePoint>& points_O) noexcept;
  void Reset() noexcept {
    fitter_.Reset();
    slid_ = false;
    rest_frames_ = 0;
  }
  // The plate of the last result, and its solution.
  [[nodiscard]] PlateSurface& answered() noexcept { return fitter_.answered(); }
  [[nodiscard]] const Solution& solution() const { return fitter_.solution(); }

 private:
  enum class Modes : std::uint8_t { kFew, kAsNeeded };
  void Read(const std::vector<SurfacePoint>& points_O);
  void KeepAll() noexcept;
  bool FitSlid(Answer* answer, double* slide) noexcept;
  bool FitHeld(Answer* answer) noexcept;
  void LearnRim(const Answer& answer) noexcept;
  void RaiseAll(const Eigen::Vector3d& rim_motion) noexcept;
  void Refit(Answer* answer, double* slide) noexcept;
  Answer FitKept(Rim rim) noexcept;
  LoadFit FitWeighed(Rim rim, Modes modes) noexcept;
  bool Sift(const LoadFit& load, Rim rim) noexcept;
  void Soften() noexcept;
  [[nodiscard]] double NoiseOfMotion(const LoadFit& load) const noexcept;
  [[nodiscard]] bool RimMoved(const LoadFit& load) const noexcept;
  [[nodiscard]] double Slide(const LoadFit& load) noexcept;
  [[nodiscard]] bool HasGrown(const LoadFit& load) const noexcept;
  [[nodiscard]] double Off(int unknowns) const noexcept;
  [[nodiscard]] double Cluster() const noexcept;
  void SeekTension(Answer* answer) noexcept;

  struct Seen {
    Eigen::Vector2d place{0, 0};     // at rest, frame O [m]
    Eigen::Vector3d moved{0, 0, 0};  // since [m]
    double sigma = 1, sideways = 0;  // along z, along the plate [m]
    double residual = 0;             // along z [m]
    double weight = 0;
    bool usable = false, kept = false;
  };
  PlateSurface& plate_;
  TighterPlate tighter_;
  double width_;  // [m]
  LoadFitter fitter_;
  Solution coarse_, tight_;  // of plate_ and tighter_ under the same load
  GridSubsample choice_;
  std::vector<Seen> seen_;
  int usable_ = 0, kept_ = 0;
  bool slid_ = false;  // the points when they were last visible
  // Motion of the rim since rest, from images without a load since the points slid: a free rim
  // bends the plate as a load does, and takes some of its force.
  Eigen::Vector3d rim_motion_{0, 0, 0};
  int rest_frames_ = 0;  // number of such images
  bool held_ = false;    // visible in the last result
  double deepest_ = 0;   // of the fitted points [m]
  double scatter_ = 1;   // of the residuals by sigma
  std::vector<Eigen::Vector2d> places_;
  std::vector<double> displacements_, sigmas_, sorted_;
};

}  // namespace palpate
