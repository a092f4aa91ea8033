#include "slave/checks/camera/indentation.h"

#include <algorithm>

#include <Eigen/LU>

namespace palpate {
namespace {

constexpr std::string_view kOtherDent = "observed and computed indentation differ";
constexpr std::string_view kOtherEdge =
    "the object's edge lies beside the computed outline: something covers it, or touches elsewhere";
// Sigma of the indentation of the edge without any model error [px].
constexpr double kFloor = 0.2;
// Difference from which on they disagree [sigma].
constexpr double kSigmas = 3.5;
// That must agree before an indentation is trusted again [images].
constexpr int kDistrust = 3;
// Consecutive edge positions beside the outline: more is an occlusion [-].
constexpr int kMostApart = 7;
// In which an indentation may stay out of sight [images].
constexpr int kUnconfirmed = 6;

bool Agrees(const CameraSample& sample) noexcept {
  const ObjectSighting& seen = *sample.object;
  if (!seen.dent_known) return true;
  const double sigma2 = kFloor * kFloor +
                        sample.dent_sigma * sample.dent_sigma * sample.dent_O.squaredNorm() +
                        sample.tip_sigma * sample.tip_sigma;
  const Eigen::Matrix2d C = seen.dent_covariance + sigma2 * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d error = seen.dent_O - sample.dent_O;
  return error.dot(C.inverse() * error) < kSigmas * kSigmas;
}

}  // namespace

void IndentationCheck::Examine(const CameraSample& sample, Findings* findings) noexcept {
  if (!sample.compares_edge() || !sample.object->known) return;
  if (sample.object->apart > kMostApart) findings->Fail(FailedCheck::kDent, kOtherEdge);
  distrust_ = Agrees(sample) ? std::max(0, distrust_ - 1) : kDistrust;
  unconfirmed_ = sample.is_dent_confirmed() ? 0 : unconfirmed_ + 1;
  if (distrust_ > 0 || unconfirmed_ > kUnconfirmed) findings->Fail(FailedCheck::kDent, kOtherDent);
}

}  // namespace palpate
