#include "slave/checks/camera/camera_checks.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Cholesky>

#include "slave/checks/camera/indentation_offset.h"
#include "slave/checks/consistency.h"
#include "slave/checks/repeat_detector.h"

namespace palpate {
namespace {

using Limits = CameraLimits;

// A function of one image.
class ImageCheck final : public Check<CameraSample> {
 public:
  using Function = Verdict (*)(const CameraSample&);
  explicit ImageCheck(Function function) : function_(function) {}
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    findings->verdict.Add(function_(sample));
  }

 private:
  Function function_;
};

Verdict Failed(FailedCheck check, std::string_view reason) {
  return {Validity::kExtrapolated, check, reason};
}

// Checks that the object's edge was found and has moved no farther than is compensated.
Verdict ExamineMotion(const CameraSample& sample) {
  Verdict verdict{Validity::kValid};
  if (!sample.compares_edge()) return verdict;
  const ObjectSighting& object = *sample.object;
  if (!object.known) return Failed(FailedCheck::kRegistration, "the object's edge is not found");
  if (object.motion.shift.norm() > Limits::kMaxShift ||
      std::abs(object.motion.angle) > Limits::kMaxTurn) {
    verdict.Fail(FailedCheck::kCameraMotion, "the image has moved too far");
  }
  if (std::abs(object.motion.growth) > Limits::kMaxGrowth) {
    verdict.Fail(FailedCheck::kScale, "the image has grown or shrunk: zoom");
  }
  return verdict;
}

bool IsBlurred(const ObjectSighting& object) {
  return object.sharpness < Limits::kSharpness || object.sharpness_at_rest < Limits::kSharpAtRest;
}

bool IsTipRough(const CameraSample& sample) {
  return sample.tip_sigma >
         std::max(Limits::kRoughTip, Limits::kRough * sample.indentation_O.norm());
}

// Checks sharpness and brightness against the first image, and the uncertainty of the tip against
// the indentation.
Verdict ExamineQuality(const CameraSample& sample) {
  if (!sample.compares_edge() || !sample.object->known) return {Validity::kValid};
  const ObjectSighting& object = *sample.object;
  if (!IsBlurred(object) && !IsTipRough(sample) && object.exposure <= Limits::kOverexposed)
    return {Validity::kValid};
  return Failed(FailedCheck::kImage, "the image is blurred, overexposed or too noisy at the tip");
}

class RepeatedImageCheck final : public Check<CameraSample> {
 public:
  // `noise`: of the first image [1/255 of full scale].
  explicit RepeatedImageCheck(double noise)
      : detector_({.learning = Limits::kLearning,
                   .noisy_share = Limits::kNoisyShare,
                   .has_noise = noise > Limits::kMinNoise}) {}

  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (!detector_.Repeats(sample.image)) return;
    findings->Fail(FailedCheck::kFrozen, "the camera repeats the same image");
  }

 private:
  RepeatDetector detector_;
};

// Checks that the encoders agree with the tip, and that it was not lost shortly before.
class AgreementCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (sample.tip.found && sample.encoder) AddEncoder(*sample.encoder);
    const Consistency::Result result = consistency_.Close();
    findings->verdict.Add(result.verdict);
    findings->widening = result.widening;
    ExamineLoss(sample, findings);
  }
  void Reset() noexcept override {
    consistency_.Reset();
    distrust_ = 0;
  }

 private:
  // An image that fails counts in the three after it as well. [images] [tuned: the case "a hand
  // comes and stays"]
  static constexpr int kWindow = 4;

  // An outline that is found after a loss may belong to another object.
  void ExamineLoss(const CameraSample& sample, Findings* findings) noexcept {
    const bool has_object = !sample.object || sample.is_broken || sample.object->known;
    distrust_ = sample.tip.found && has_object ? std::max(0, distrust_ - 1) : kWindow;
    if (distrust_ > 0) findings->Fail(FailedCheck::kTip, "tip or object was lost a moment ago");
  }
  void AddEncoder(const EncoderInnovation& innovation) noexcept {
    for (const double value : innovation.value) {
      consistency_.Add({FailedCheck::kArm, "the tip is not where the encoders report it", value,
                        innovation.sigma});
    }
  }

  Consistency consistency_{kWindow};
  int distrust_ = 0;  // images until tip and object are trusted after a loss
};

// Compares observed and computed indentation. It uses the gate of one image and flags a few images
// after a failure: a window of Consistency would detect fewer tip errors at the beginning of a
// contact.
class IndentationCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (!sample.compares_edge() || !sample.object->known) return;
    if (sample.object->apart > Limits::kMaxApart) {
      findings->Fail(FailedCheck::kIndentation,
                     "the object's edge lies beside the computed outline: something covers it, or "
                     "touches elsewhere");
    }
    const bool is_confirmed =
        sample.object->indentation_known || sample.indentation_O.norm() < Limits::kSmallIndentation;
    distrust_ = Agrees(sample) ? std::max(0, distrust_ - 1) : Limits::kDistrust;
    unconfirmed_ = is_confirmed ? 0 : unconfirmed_ + 1;
    if (distrust_ > 0 || unconfirmed_ > Limits::kUnconfirmed) {
      findings->Fail(FailedCheck::kIndentation, "observed and computed indentation differ");
    }
    if (BeginsElsewhere(sample)) {
      findings->Fail(FailedCheck::kIndentation,
                     "depth begins elsewhere than the indentation: the tool's end, or the surface, "
                     "is not where the scene has it");
    }
  }
  void Reset() noexcept override {
    distrust_ = unconfirmed_ = 0;
    offset_.Reset();
  }

 private:
  static bool Agrees(const CameraSample& sample) noexcept {
    const ObjectSighting& object = *sample.object;
    if (!object.indentation_known) return true;
    const double model = sample.indentation_sigma * sample.indentation_O.norm();
    const double sigma2 = Limits::kEdgeSigma * Limits::kEdgeSigma + model * model +
                          sample.tip_sigma * sample.tip_sigma;
    const Eigen::LLT<Eigen::Matrix2d> C(object.indentation_covariance +
                                        sigma2 * Eigen::Matrix2d::Identity());
    const Eigen::Vector2d residual = C.matrixL().solve(object.indentation_O - sample.indentation_O);
    return residual.squaredNorm() < Limits::kIndentationGate;
  }

  bool BeginsElsewhere(const CameraSample& sample) noexcept {
    const double depth = -sample.normal_O.dot(sample.indentation_O);
    if (!(depth > 0)) {
      offset_.Reset();
      return false;
    }
    const ObjectSighting& object = *sample.object;
    if (sample.tip.found && object.indentation_known && !IsTipRough(sample)) {
      const Eigen::Vector2d& n = sample.normal_O;
      offset_.Add({.depth = depth,
                   .shown = -n.dot(object.indentation_O),
                   .sigma = std::sqrt(n.dot(object.indentation_covariance * n) +
                                      sample.tip_sigma * sample.tip_sigma)},
                  sample.indentation_sigma, Limits::kEdgeSigma);
    }
    const double sigma = std::hypot(offset_.sigma(), sample.place_sigma);
    return offset_.value() * offset_.value() > Limits::kIndentationGate * sigma * sigma;
  }

  IndentationOffset offset_;  // of this contact
  int distrust_ = 0;          // images until an indentation is trusted again
  int unconfirmed_ = 0;       // images since the indentation was last detected
};

// The tool in the first image is the scene's, at the manipulator's home.
Verdict ExamineTool(const Scene& scene, const FirstImage& first) {
  if (!first.p_I_tip || first.d_I.isZero(0)) return {Validity::kValid};
  if (!scene.sense.Find<TipTracking>()->template_file.empty()) return {Validity::kValid};
  const Verdict elsewhere =
      Failed(FailedCheck::kArm, "the tool is not at the manipulator's home in the first image");
  const GreyFormat format(first.image);
  const auto end = DetectToolEnd(first.image, format, *first.p_I_tip, first.d_I, first.tool);
  if (!end) {
    const bool goes_on = ToolGoesOn(first.image, format, *first.p_I_tip, first.d_I, first.tool);
    return goes_on ? elsewhere : Verdict(Validity::kValid);
  }
  const bool beyond = std::abs(end->beyond) > Limits::kToolElsewhere;
  const bool aside = std::abs(end->aside) > Limits::kToolElsewhere;
  const bool wide = std::abs(end->width / first.tool.width - 1) > Limits::kToolWidth;
  if (beyond || (aside && !wide)) return elsewhere;
  if (aside == wide) return {Validity::kValid};  // both fail: something covers a side of the tool
  return Failed(FailedCheck::kScale, "the tool is not as wide as the scene's in the first image");
}

class ToolAtStartCheck final : public Check<CameraSample> {
 public:
  explicit ToolAtStartCheck(const Verdict& verdict) : verdict_(verdict) {}
  void Examine(const CameraSample& /*sample*/, Findings* findings) noexcept override {
    findings->verdict.Add(verdict_);
  }

 private:
  Verdict verdict_;
};

}  // namespace

Checks<CameraSample> MakeCameraChecks(const Scene& scene, const FirstImage& first) {
  Checks<CameraSample> checks;
  checks.Add(std::make_unique<ImageCheck>(ExamineMotion));
  checks.Add(std::make_unique<ImageCheck>(ExamineQuality));
  checks.Add(std::make_unique<RepeatedImageCheck>(first.noise));
  checks.Add(std::make_unique<AgreementCheck>());
  checks.Add(std::make_unique<IndentationCheck>());
  checks.Add(std::make_unique<ToolAtStartCheck>(ExamineTool(scene, first)));
  return checks;
}

}  // namespace palpate
