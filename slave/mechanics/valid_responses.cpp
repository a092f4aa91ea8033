#include "slave/mechanics/valid_responses.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

// Smallest accepted eigenvalue of a stiffness relative to its largest one, negative [-].
// Collocation of boundary elements is not symmetric: -1.5e-4 was measured on a strip under a narrow
// tool.
constexpr double kIndefinite = 1e-3;

bool IsError(double value) {
  return std::isfinite(value) && value >= 0;
}

bool IsDefinite(const Eigen::Matrix3d& stiffness) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect((stiffness + stiffness.transpose()) / 2, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d& values = solver.eigenvalues();
  return values[0] >= -kIndefinite * std::abs(values[2]);
}

const char* Violation(const ContactResponse& response) {
  if (!response.force_O.allFinite()) return "force_O is not finite";
  if (!response.displacement_O.allFinite()) return "displacement_O is not finite";
  if (!response.stiffness_O.allFinite()) return "stiffness_O is not finite";
  if (response.validity == Validity::kValid && !IsDefinite(response.stiffness_O))
    return "stiffness_O has a negative eigenvalue";
  if (response.moment_O && !response.moment_O->allFinite()) return "moment_O is not finite";
  if (!IsError(response.moment_sigma)) return "moment_sigma is not finite and at least 0";
  if (!IsError(response.force_error)) return "force_error is not finite and at least 0";
  if (!IsError(response.displacement_error))
    return "displacement_error is not finite and at least 0";
  return nullptr;
}

}  // namespace

std::string FirstViolation(std::span<const ContactResponse> responses) {
  for (std::size_t i = 0; i < responses.size(); ++i) {
    if (responses[i].validity == Validity::kFailed) continue;
    if (const char* violation = Violation(responses[i]))
      return "contact " + std::to_string(i) + ": " + violation;
  }
  return {};
}

}  // namespace palpate
