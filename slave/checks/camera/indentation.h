// The indentation of the object's edge is the one that the model computes for the tip.
#pragma once

#include <algorithm>

#include <Eigen/LU>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class IndentationCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (!sample.compares_edge() || !sample.object->known) return;
    if (sample.object->apart > kMostApart) findings->Fail(FailedCheck::kDent, kOtherEdge);
    distrust_ = Agrees(sample) ? std::max(0, distrust_ - 1) : kDistrust;
    unconfirmed_ = sample.is_dent_confirmed() ? 0 : unconfirmed_ + 1;
    if (distrust_ > 0 || unconfirmed_ > kUnconfirmed)
      findings->Fail(FailedCheck::kDent, kOtherDent);
  }
  void Reset() noexcept override { distrust_ = unconfirmed_ = 0; }

 private:
  static constexpr std::string_view kOtherDent = "observed and computed indentation differ";
  static constexpr std::string_view kOtherEdge =
      "the object's edge lies beside the computed outline: something covers it, or touches "
      "elsewhere";
  // Sigma of the indentation of the edge without any model error [px].
  static constexpr double kFloor = 0.2;
  // Difference from which on they disagree [sigma].
  static constexpr double kSigmas = 3.5;
  // That must agree before an indentation is trusted again [images]. [tuned:
  // APressWithoutItsDentIsNotValid]
  static constexpr int kDistrust = 3;
  // Consecutive edge positions beside the outline: more is an occlusion [-].
  static constexpr int kMostApart = 7;
  // In which an indentation may stay out of sight [images].
  static constexpr int kUnconfirmed = 6;

  static bool Agrees(const CameraSample& sample) noexcept {
    const ObjectSighting& seen = *sample.object;
    if (!seen.dent_known) return true;
    const double sigma2 = kFloor * kFloor +
                          sample.dent_sigma * sample.dent_sigma * sample.dent_O.squaredNorm() +
                          sample.tip_sigma * sample.tip_sigma;
    const Eigen::Matrix2d C = seen.dent_covariance + sigma2 * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d error = seen.dent_O - sample.dent_O;
    return error.dot(C.inverse() * error) < kSigmas * kSigmas;
  }

  int unconfirmed_ = 0;  // images since the indentation was last detected
  int distrust_ = 0;     // images until an indentation is trusted again
};

}  // namespace palpate
