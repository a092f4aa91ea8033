#include "master/haptics/torque.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr double kMaxSensedMoment = 1e9;  // larger moments are invalid [N m]

// Returns the component of `part` along `whole` relative to `whole`, from 0 to 1.
double Share(const Eigen::Vector3d& part, const Eigen::Vector3d& whole) {
  const double size = whole.squaredNorm();
  return size > 0 ? std::clamp(part.dot(whole) / size, 0.0, 1.0) : 0;
}

}  // namespace

Eigen::Vector3d TorqueAtDevice(const SlaveState& newest, const ForceChain& chain,
                               const TeleopTransform& transform) noexcept {
  if (!newest.moment || !chain.force_known) return {0, 0, 0};
  const Eigen::Vector3d& moment = *newest.moment;
  if (!moment.allFinite() || moment.cwiseAbs().maxCoeff() > kMaxSensedMoment) return {0, 0, 0};
  const double share = Share(chain.local, chain.estimated) * Share(chain.sent, chain.scaled);
  return share * MomentToMaster(transform, moment);
}

}  // namespace palpate
