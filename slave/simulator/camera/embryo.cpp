#include "slave/simulator/camera/embryo.h"

#include <random>

#include "slave/reference/planar/true_body.h"

namespace palpate::simulation {
namespace {

constexpr std::uint32_t kTargetStream =
    0x7461;  // separates the target's random numbers from others of the seed

// Returns the same numbers on every platform, unlike std::uniform_real_distribution.
double Uniform(std::mt19937& random) {
  return (static_cast<double>(random()) + 0.5) / 4294967296.0;
}

}  // namespace

Embryo::Embryo(const EmbryoSite& options, std::uint32_t seed, double radius,
               const Eigen::Vector2d& direction_O)
    : options_(options), seed_(seed) {
  std::seed_seq sequence{seed, kTargetStream};
  std::mt19937 random(sequence);
  const double along = kTargetAlong * (2 * Uniform(random) - 1);
  const double across = kTargetAcross * (2 * Uniform(random) - 1);
  const Eigen::Vector2d aside(-direction_O.y(), direction_O.x());
  target_O_ = radius * (along * direction_O + across * aside);
}

double Embryo::Stiffening(double depth) const noexcept {
  const double beyond = depth / options_.linear_to - 1;
  return beyond > 0 ? 1 + options_.stiffening * beyond * beyond : 1;
}

double Embryo::PunctureDepth(int insertion) const noexcept {
  std::seed_seq sequence{seed_, static_cast<std::uint32_t>(insertion)};
  std::mt19937 random(sequence);
  return options_.puncture[0] + Uniform(random) * (options_.puncture[1] - options_.puncture[0]);
}

Eigen::Vector3d TargetOf(const Scene& scene) {
  const TrueBody body(scene);
  const Eigen::Matrix2d R_OS = body.X_SO().linear().transpose();
  const Embryo embryo(scene.site.embryo.value(), scene.site.seed, 0.5 * body.larger_side(),
                      R_OS * scene.tool->direction.normalized());
  const Eigen::Vector2d p_S = body.X_SO() * embryo.target_O();
  return {p_S.x(), p_S.y(), 0};
}

}  // namespace palpate::simulation
