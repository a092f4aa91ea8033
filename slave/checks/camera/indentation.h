// The indentation of the object's edge is the one that the model computes for the tip.
#pragma once

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class IndentationCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override;
  void Reset() noexcept override { distrust_ = unconfirmed_ = 0; }

 private:
  int unconfirmed_ = 0;  // images since the indentation was last detected
  int distrust_ = 0;     // images until an indentation is trusted again
};

}  // namespace palpate
