// A plate's load from points of which some may be wrong and whose frame may have moved: what the
// least squares of LoadFitter need around them where eyes err.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/fit/load_fit.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Few points instead of many, spread evenly over a round plate: what a fit costs grows with their
// number, what it gains from neighbours that tell the same soon does not.
// One thread; allocation-free after the first call with as many points.
class GridSubsample {
 public:
  static constexpr int kMost = 128;  // points that are taken as they are; beyond, at most so many
  static constexpr int kNone = -1;   // of a square none of whose points is seen

  // `radius` of the plate about the origin of O [m].
  explicit GridSubsample(double radius) : radius_(radius) {}

  // Indices of points on the plate, frame O. Where more than kMost rest there: of each square of a
  // grid over it, the point seen nearest to its middle, or kNone; their number depends on the
  // places at rest alone.
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
  // Of a rig or membrane that moves as a whole, what is put right [m]: along the plate, across it,
  // and at the rim by a tilt. Eyes that turn about themselves raise nothing.
  static constexpr double kMostSlide = 4e-3, kMostRise = 0.3e-3, kMostTilt = 1.5e-3;

  // Keeps references to the plates; see LoadFitter. `tighter`: the answer tells how much of that
  // tension the points ask for.
  RobustPlateFit(PlateSurface& plate, double width, PlateSurface* finer = nullptr,
                 TighterPlate tighter = {})
      : plate_(plate),
        tighter_(tighter),
        width_(width),
        fitter_(plate, width, finer),
        choice_(plate.radius()) {}

  struct Answer {
    LoadFit load;
    int points = 0;    // on the plate, seen and chosen
    int left_out = 0;  // of them: they contradict the others
    // The rim or the eyes have moved since rest; the load is free of it. A motion along the plate
    // is one that no load makes: one as small as kMostSlide, kMostRise and kMostTilt is put right.
    bool moved = false, put_right = false;
    double cluster = 0;  // largest mean residual of neighbouring points that stands out of noise
                         // and law together, by the largest deflection; 0: none does
    // LoadFitter::Seek for the plate's tension at rest, and what the plate's law may make of it
    // [N/m].
    LoadFitter::Sought tension;
    double sigma_of_law = 0;
    bool flat = true;             // at rest
    double off = 0, deepest = 0;  // rms of the kept residuals, largest deflection fitted [m]
    bool grown = false;  // all points have moved apart or together along the plate, by more than
                         // noise and a press make of them
  };
  // Points in frame O, of many an even choice; those not seen, off the plate, not finite or without
  // a sigma do not count. A point more than five standard deviations (of the points' own scatter)
  // and a twentieth of the largest deflection from the fit is left out and the load fitted anew.
  // The displacement of a point is that of its own place at rest: a point that moved sideways is
  // used where it rests.
  Answer Fit(const std::vector<SurfacePoint>& points_O) noexcept;
  void Reset() noexcept {
    fitter_.Reset();
    slid_ = false;
    rest_frames_ = 0;
  }
  // The plate that gave the last answer, as it is pressed.
  [[nodiscard]] PlateSurface& answered() noexcept { return fitter_.answered(); }

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
  GridSubsample choice_;
  std::vector<Seen> seen_;
  int usable_ = 0, kept_ = 0;
  bool slid_ = false;  // the points together, when they were seen last
  // Of the rim since rest, by pictures without a load since the points slid: a free rim bends the
  // plate as a load does, and takes some of its force.
  Eigen::Vector3d rim_motion_{0, 0, 0};
  int rest_frames_ = 0;  // such pictures
  bool held_ = false;    // there, in the last answer
  double deepest_ = 0;   // of the fitted points [m]
  double scatter_ = 1;   // of the residuals by sigma
  std::vector<Eigen::Vector2d> places_;
  std::vector<double> displacements_, sigmas_, sorted_;
};

}  // namespace palpate
