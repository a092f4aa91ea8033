// A force-position curve learnt from estimated forces, for sensing without an object model, such as
// a network of a fingertip without a pose.
#pragma once

#include <array>

#include <Eigen/Core>

#include "shared/state/surface_patch.h"

namespace palpate {

// Force along the mean direction of the forces, at positions kSpacing apart and linear between
// them. Each is the mean of the estimates near it; old estimates have less weight (kMemory).
// Positions without an estimate use a straight line through the newest forces and positions, whose
// memory is kLineMemory. Allocation-free.
class ForceLaw {
 public:
  // `depth`: range of the curve [m], > 0; `period` of the samples [s].
  ForceLaw(double depth, double period);

  // The force of the object on the tool at `p_S` [m], one standard deviation `sigma` [N].
  void AddSample(const Eigen::Vector3d& p_S, const Eigen::Vector3d& force_S, double sigma) noexcept;
  // Enough contact forces were estimated.
  [[nodiscard]] bool known() const noexcept { return line_.n >= kEnough; }
  // Size of the force at `p_S` [N], >= 0.
  [[nodiscard]] double At(const Eigen::Vector3d& p_S) const noexcept {
    return AtPlace(PlaceOf(p_S));
  }
  // The plane of one node at which the force begins, and the curve over depth below it.
  void Export(SurfacePatch* patch, PatchLaw* law) const noexcept;

 private:
  static constexpr int kPlaces = 256;
  static constexpr double kEnough = 3;        // samples
  static constexpr double kMemory = 3;        // [s]
  static constexpr double kLineMemory = 0.5;  // [s]
  static constexpr double kPrior = 0.3;       // number of samples in the line
  static constexpr double kTouch = 5;         // sigmas of a contact force

  struct Line {
    double n = 0, x = 0, f = 0, xx = 0, xf = 0;
    [[nodiscard]] double slope() const noexcept;
  };
  struct Place {
    double weight = 0, force = 0;  // of samples; their weighted sum
  };
  // Along the direction, into the object [m].
  [[nodiscard]] double PlaceOf(const Eigen::Vector3d& p_S) const noexcept {
    return -n_.dot(p_S - origin_);
  }
  [[nodiscard]] double AtPlace(double x) const noexcept;
  [[nodiscard]] double ByLine(double x) const noexcept;
  [[nodiscard]] double ValueOf(int place) const noexcept;
  // Returns the position at which the force begins [m].
  [[nodiscard]] double Surface() const noexcept;

  double depth_, spacing_, forget_, forget_line_;
  bool begun_ = false;
  Eigen::Vector3d n_{0, 1, 0}, origin_{0, 0, 0};
  Line line_;
  std::array<Place, kPlaces> places_{};
};

}  // namespace palpate
