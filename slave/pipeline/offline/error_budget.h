// Where the force error comes from, at a site that knows the truth: what the model would say of the
// true indentation is the model's error, the rest is that of sensing.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "shared/state/slave_state.h"

namespace palpate {

// The forces on one tool or fingertip in one sample, any one frame [N].
struct ComparedForces {
  Eigen::Vector3d estimated{0, 0, 0};  // not finite: unknown
  Eigen::Vector3d truth{0, 0, 0};
  // Size of what the model has at the true indentation; NaN: it tells none.
  double model_at_truth = std::numeric_limits<double>::quiet_NaN();
};

inline const Eigen::Vector3d kUnknownForce =
    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
// Size of the force that the master renders of `local` at this depth [m] below its plane [N].
inline double ForceAt(const LocalModel& local, double depth) {
  return (local.force + local.stiffness * local.normal * depth).norm();
}

// Over samples in contact.
struct ErrorBudget {
  std::uint64_t count = 0;
  double rms = 0;           // of the force's vector, estimated minus true [N]
  double peak_error = 0;    // of the same, the largest [N]
  double peak_force = 0;    // the largest true one [N]
  double model_rms = 0;     // of sizes: of the model at the true indentation, minus true [N]
  double tracking_rms = 0;  // of sizes: estimated, minus of the model at the true indentation [N]
};

// Samples in contact are those in which truth or estimate exceed 1 % of the true peak. Unknown
// forces cannot be compared.
ErrorBudget BudgetOf(const std::vector<ComparedForces>& compared);
// As summary.json has it; null where nothing in contact was compared. `samples`: the name of the
// key that counts them, contact_`samples`.
nlohmann::ordered_json ToJson(const ErrorBudget& budget, const std::string& samples);

}  // namespace palpate
