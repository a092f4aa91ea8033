// What one picture or tactile sample told. Frame S.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "shared/state/slave_state.h"

namespace palpate {

struct ContactEstimate {
  std::uint64_t sequence = 0;  // of the picture or sample
  Time sensed_at{};
  Eigen::Vector3d p_S_tip =
      Eigen::Vector3d::Zero();  // [m]; the last seen one while tracking is lost
  Eigen::Vector3d p_S_contact =
      Eigen::Vector3d::Zero();           // place touched, or the nearest, at rest [m]
  double depth = 0;                      // indentation along the normal [m]; 0: no contact
  std::optional<Eigen::Vector3d> force;  // object on tool [N]; nullopt: unknown
  double sigma = 0;                      // of the force's magnitude [N]
  Validity validity = Validity::kFailed;
  LocalModel local_model;
  Events events;
  // Of scenes with several fingertips; the first is the tool of the fields above.
  std::array<FingerState, kMaxFingers> fingers;
  int finger_count = 0;
};

}  // namespace palpate
