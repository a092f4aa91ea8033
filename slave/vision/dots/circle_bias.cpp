#include "slave/vision/dots/circle_bias.h"

namespace palpate {

std::optional<Eigen::Vector2d> CircleCentroidBias(const Lens& lens, const Eigen::Vector3d& p_C,
                                                  const Eigen::Vector3d& n_C,
                                                  double radius) noexcept {
  const double square = radius * radius;
  const Eigen::Vector3d middle =
      p_C.z() * p_C + square * n_C.z() * n_C - square * Eigen::Vector3d::UnitZ();
  if (!(p_C.z() > 0 && middle.z() > 0)) return std::nullopt;
  const auto seen = Project(lens, middle);
  const auto centre = Project(lens, p_C);
  if (!seen || !centre) return std::nullopt;
  return *seen - *centre;
}

}  // namespace palpate
