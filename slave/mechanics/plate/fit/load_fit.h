// Position and force of a load on a plate from its measured deflection: the inverse of a plate
// model. The position of the largest deflection is not that of the load: using it loses 15 % of the
// force at half the radius and 36 % at 0.7 of it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/fit/load_search.h"
#include "slave/mechanics/plate/plate_surface.h"

namespace palpate {

struct LoadFit {
  Eigen::Vector2d p_O{0, 0};  // centre of the tool [m]
  double force = 0;           // along z, of the tool on the plate [N]: negative pushes
  // Covariance of x, y [m] and force [N], from the points' sigmas, linear at the solution.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  // rms of (measured - fitted) / sigma, with the number of points minus 3 (minus 6 with
  // Rim::kMayMove) as divisor; about 1 if all is well.
  double residual = 0;
  // Motion of the rim along z, c0 + c1 x + c2 y with x and y in radii [m]. If the rim is assumed
  // fixed: the part of such a motion in the residuals, which is less than the true motion because
  // the load explains a part.
  Eigen::Vector3d rim_motion{0, 0, 0};
  // kFailed: not identified; kExtrapolated: beyond the plate's range, or a residual beyond 3; see
  // reason.
  Validity validity = Validity::kFailed;
  bool nothing = false;  // kFailed because no load exceeds the noise
  std::string_view reason;
};

// Whether the clamped rim is assumed fixed, or may have moved along z and tilted, which adds three
// unknowns.
enum class Rim : std::uint8_t { kStays, kMayMove };

// Weighted nonlinear least squares in (x, y, force) by the Levenberg-Marquardt method. Starts from
// the last solution if it fits, else from the best of 91 positions over the plate with the
// small-deflection shape, so that it does not end in a local minimum.
class LoadFitter {
 public:
  // Stores a reference to the plate and uses its Respond. `tool`: the tool, with a diameter < 0.9
  // of the plate's. `finer`: the same plate with more modes, used if the first does not resolve the
  // shape (plate_law.h): up to three steps with its derivatives from the first solution, so at most
  // four solutions of the finer plate; the whole fit if these fail. Throws std::invalid_argument.
  LoadFitter(PlateSurface& plate, const PlateSurface::Tool& tool, PlateSurface* finer = nullptr);

  // The load that explains displacements along z [m] with sigmas [m] > 0 at points [m], all frame
  // O; a point with an infinite sigma does not count. Not identified: fewer than four points (seven
  // if the rim may move), a point off the plate, values not finite; no load above the noise (five
  // sigma; if the points scatter by much less than their sigmas, of that scatter); a load at the
  // rim or beyond; a position with a sigma above a quarter radius. A load so small that the points
  // do not determine its position is placed where the small-deflection shape fits best,
  // kExtrapolated. Allocation-free after the first call with as many points.
  [[nodiscard]] LoadFit Fit(std::span<const Eigen::Vector2d> p_O,
                            std::span<const double> displacement, std::span<const double> sigma,
                            Rim rim = Rim::kStays) noexcept;
  // Fits like Fit, without the finer plate.
  [[nodiscard]] LoadFit FitCoarsely(std::span<const Eigen::Vector2d> p_O,
                                    std::span<const double> displacement,
                                    std::span<const double> sigma, Rim rim) noexcept;
  // The plate that was solved last, and its solution.
  [[nodiscard]] PlateSurface& answered() noexcept { return *asked_; }
  [[nodiscard]] const Solution& solution() const { return solution_; }
  // Evidence in the last residuals for another influence on the plate, such as a tension at rest:
  // the amount that explains them, in addition to another load.
  struct Sought {
    double amount = 0, sigma = 0;  // 0: the points cannot distinguish it from another load
    double force = 0;              // change of the load per unit amount [N]
  };
  // `change`: change of the points' displacements under the same load per unit amount [m], one per
  // point. The result's sigma follows from the points' sigmas. No allocation.
  [[nodiscard]] Sought Seek(std::span<const double> change) noexcept;
  // Forgets the last solution.
  void Reset() { last_.reset(); }
  // Limits the number of plate solutions until the next call of this function; each solution of the
  // finer plate counts as kFinerCost. Beyond the limit no load explains the points. Initially there
  // is no limit.
  void Allow(long presses) noexcept { allowed_ = presses; }
  static constexpr long kFinerCost = 10;

 private:
  struct Guess {
    Eigen::Vector2d place{0, 0};  // [radii]
    double force = 0;             // along z [N]
  };
  struct Measured {
    Eigen::Vector2d place;  // [radii]
    double value, sigma;    // displacement along z [m]
  };

  std::string_view Read(std::span<const Eigen::Vector2d> p_O, std::span<const double> displacement,
                        std::span<const double> sigma);
  bool HoldAt(const plate::LoadSearch::Found& found, Guess* guess) noexcept;
  [[nodiscard]] int Freedom() const noexcept {
    return std::max(1, count_ - (rim_ == Rim::kStays ? 3 : 6));
  }
  bool FitFaint(LoadFit* fit) noexcept;
  bool DescendTwice(Guess* guess, LoadFit* fit) noexcept;
  bool Descend(Guess* guess, LoadFit* fit) noexcept;
  bool Step(const Eigen::Matrix3d& normal, double* damping, Guess* guess) noexcept;
  bool Linearise(const Guess& guess) noexcept;
  void Compare(Eigen::VectorXd* misfit) noexcept;
  bool Misfit(const Guess& guess, Eigen::VectorXd* misfit) noexcept;
  [[nodiscard]] bool AsksForMoreModes(const Guess& guess) noexcept;
  bool Refine(Guess* guess, LoadFit* fit) noexcept;
  bool Press(const Guess& guess) noexcept;
  void FillResult(const Guess& guess, LoadFit* fit) noexcept;
  [[nodiscard]] Eigen::Vector3d RimMotion() noexcept;

  PlateSurface& plate_;
  PlateSurface* finer_;
  PlateSurface* asked_;  // one of the two
  Solution solution_;    // of asked_
  PlateSurface::Tool tool_;
  double margin_;                         // largest distance from the centre [radii]
  std::optional<Guess> last_;             // last solution of plate_
  Validity pressed_ = Validity::kFailed;  // of the last solution
  long allowed_ = std::numeric_limits<long>::max();
  std::vector<Measured> measured_;
  std::vector<Eigen::Vector2d> places_;  // [radii]
  Eigen::VectorXd values_, weights_;     // displacements / sigma, 1 / sigma
  plate::LoadSearch search_;
  int count_ = 0;  // of those that count
  Rim rim_ = Rim::kStays;
  plate::RimMotions rims_;
  Eigen::Vector3d seen_rim_motion_{0, 0, 0};  // from the measured displacements only
  Eigen::VectorXd misfit_, tried_, shape_;    // (measured - fitted) / sigma
  Eigen::Matrix<double, Eigen::Dynamic, 3>
      by_;                 // minus its derivatives by radii and by force_unit_
  double force_unit_ = 1;  // size of the present force [N]
};

}  // namespace palpate
