#include "slave/tactile/localise/fitted_localiser.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "shared/text/text.h"
#include "slave/tactile/localise/direction_mean.h"
#include "slave/tactile/localise/localiser.h"

namespace palpate {
namespace {

// The fit: kernel ridge regression of what the formula leaves of the measured normals. Weights of
// the ridge to choose from; the kernel of a sample with itself is 1. The least stands where
// stretches of one recording still profit from less: another recording would not.
constexpr std::array<double, 3> kRidges{3, 10, 30};
constexpr double kUnitTolerance = 1e-3;
constexpr int kLeastPerFold = 10;

struct Sample {
  SignalShape u;
  Eigen::Vector3d formula;   // n_0
  Eigen::Vector3d measured;  // unit
};
using Samples = std::vector<Sample>;

void Refuse(const std::string& what) {
  throw std::invalid_argument("fit of a localiser: " + what);
}

void CheckInput(std::span<const TactileSignals> changes, std::span<const Eigen::Vector3d> normals_F,
                const FitLocaliserOptions& options) {
  if (changes.size() != normals_F.size()) {
    Refuse(std::to_string(changes.size()) + " samples and " + std::to_string(normals_F.size()) +
           " normals: accepted is one normal per sample");
  }
  if (!(options.threshold > 0) || !std::isfinite(options.threshold)) {
    Refuse("threshold: accepted is a finite number of counts > 0");
  }
  Require(options.centres >= 1 && options.centres <= kMostLocaliserCentres,
          "fit of a localiser: centres", options.centres,
          "1 to " + std::to_string(kMostLocaliserCentres));
  Require(options.folds >= 2 && options.folds <= 20, "fit of a localiser: folds", options.folds,
          "2 to 20");
}

Samples ThoseInContact(std::span<const TactileSignals> changes,
                       std::span<const Eigen::Vector3d> normals_F,
                       const LocaliserWeights& weights) {
  // Directions do not depend on the radius: the core's will do.
  const DirectionMean mean(weights.layout, 1.0);
  const SignalCheck check(weights.layout, weights.threshold);
  Samples samples;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const SignalFlaws flaws = check.Check(changes[k], FingerReading{});
    const bool is_unit = std::abs(normals_F[k].norm() - 1) < kUnitTolerance;
    if (!flaws.finite || !is_unit) {
      Refuse("sample " + std::to_string(k) + ": accepted are finite changes and unit normals");
    }
    const auto direction = mean.Mean(PressureWeighted(changes[k], flaws, weights.threshold));
    if (!direction) continue;
    samples.push_back(
        {ShapeOf(changes[k], weights.quiet), direction->n_F, normals_F[k].normalized()});
  }
  return samples;
}

// Evenly spaced, at most `count`.
Samples Thinned(const Samples& samples, int count) {
  const auto wanted = std::min(samples.size(), static_cast<std::size_t>(count));
  Samples thinned;
  for (std::size_t k = 0; k < wanted; ++k) thinned.push_back(samples[k * samples.size() / wanted]);
  return thinned;
}

// R and the corrections from `samples`, into `weights`.
void Regress(const Samples& samples, int centres, LocaliserWeights* weights) {
  Eigen::Matrix3d measured_by_formula = Eigen::Matrix3d::Zero();
  for (const Sample& s : samples) measured_by_formula += s.measured * s.formula.transpose();
  weights->R = BestRotation(measured_by_formula);
  const Samples chosen = Thinned(samples, centres);
  const auto m = static_cast<Eigen::Index>(chosen.size());
  weights->centres.resize(kElectrodeCount, m);
  Eigen::MatrixX3d left(m, 3);
  for (Eigen::Index j = 0; j < m; ++j) {
    const Sample& s = chosen[static_cast<std::size_t>(j)];
    weights->centres.col(j) = s.u;
    left.row(j) = s.measured - weights->R * s.formula;
  }
  Eigen::MatrixXd kernel(m, m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const auto apart = (weights->centres.colwise() - weights->centres.col(j)).colwise();
    kernel.col(j) = (-weights->gamma * apart.squaredNorm().array()).exp().transpose();
  }
  kernel.diagonal().array() += weights->ridge;
  weights->corrections = kernel.llt().solve(left).transpose();
}

double AngleOf(const Sample& sample, const LocaliserWeights& weights) {
  const Eigen::Vector3d n = weights.R * sample.formula + Correction(weights, sample.u);
  return std::acos(std::clamp(n.normalized().dot(sample.measured), -1.0, 1.0));
}

// Errors of all samples, each stretch fitted by the others.
std::vector<double> LeftOutErrors(const Samples& samples, const FitLocaliserOptions& options,
                                  LocaliserWeights weights) {
  const auto folds = static_cast<std::size_t>(options.folds);
  std::vector<double> errors;
  for (std::size_t k = 0; k < folds; ++k) {
    const auto begin = static_cast<std::ptrdiff_t>(samples.size() * k / folds);
    const auto end = static_cast<std::ptrdiff_t>(samples.size() * (k + 1) / folds);
    Samples others(samples.begin(), samples.begin() + begin);
    others.insert(others.end(), samples.begin() + end, samples.end());
    Regress(others, options.centres, &weights);
    for (auto s = begin; s < end; ++s) {
      errors.push_back(AngleOf(samples[static_cast<std::size_t>(s)], weights));
    }
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

void CheckCount(std::size_t in_contact, const FitLocaliserOptions& options) {
  const auto wanted = static_cast<std::size_t>(kLeastPerFold * options.folds);
  if (in_contact >= wanted) return;
  Refuse(std::to_string(in_contact) + " samples are in contact: accepted are " +
         std::to_string(wanted) + " or more");
}

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

class FittedLocaliser final : public Localiser {
 public:
  FittedLocaliser(LocaliserWeights weights, double radius)
      : weights_(std::move(weights)),
        mean_(weights_.layout, radius),
        check_(weights_.layout, weights_.threshold) {}

  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override {
    const SignalFlaws flaws = check_.Check(change, raw);
    if (!flaws.finite) return NoPlace(TouchPlace::Status::kFailed);
    const Intensities intensities = PressureWeighted(change, flaws, weights_.threshold);
    if (intensities.active == 0) return NoPlace(TouchPlace::Status::kNoContact, flaws.any());
    const auto direction = mean_.Mean(intensities);
    if (!direction) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
    const Eigen::Vector3d n_F =
        weights_.R * direction->n_F + Correction(weights_, ShapeOf(change, weights_.quiet));
    if (!(n_F.norm() > kCancelled)) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
    const Eigen::Vector3d p_F = mean_.PlaceOf({n_F.normalized(), direction->axis_x});
    return FoundPlace(mean_.surface(), p_F, weights_.sigma_angle, flaws.any(), intensities.active);
  }
  [[nodiscard]] std::string_view name() const override { return "fitted"; }

 private:
  static constexpr double kCancelled = 1e-6;

  LocaliserWeights weights_;
  DirectionMean mean_;
  SignalCheck check_;
};

}  // namespace

Eigen::Matrix3d BestRotation(const Eigen::Matrix3d& measured_by_found) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(measured_by_found,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

LocaliserWeights FitLocaliser(std::span<const TactileSignals> changes,
                              std::span<const Eigen::Vector3d> normals_F,
                              const ElectrodeLayout& layout, const FitLocaliserOptions& options) {
  CheckInput(changes, normals_F, options);
  LocaliserWeights weights;
  weights.layout = layout;
  weights.threshold = options.threshold;
  const Samples samples = ThoseInContact(changes, normals_F, weights);
  CheckCount(samples.size(), options);
  weights.samples = static_cast<int>(samples.size());
  weights.median_error = std::numbers::pi;
  LocaliserWeights best = weights;
  for (const double ridge : kRidges) {
    weights.ridge = ridge;
    const std::vector<double> errors = LeftOutErrors(samples, options, weights);
    const double median = Quantile(errors, 0.5);
    if (median >= best.median_error) continue;
    best.ridge = ridge;
    best.median_error = median;
    best.sigma_angle = Quantile(errors, 0.68);
  }
  Regress(samples, options.centres, &best);
  return best;
}

SignalShape ShapeOf(const TactileSignals& change, double quiet) noexcept {
  SignalShape u;
  for (int i = 0; i < kElectrodeCount; ++i) {
    u[i] = static_cast<double>(change[static_cast<std::size_t>(i)]);
  }
  return u / (quiet + u.norm());
}

Eigen::Vector3d Correction(const LocaliserWeights& weights, const SignalShape& u) noexcept {
  Eigen::Vector3d correction(0, 0, 0);
  for (Eigen::Index j = 0; j < weights.centres.cols(); ++j) {
    const double apart = (weights.centres.col(j) - u).squaredNorm();
    correction += std::exp(-weights.gamma * apart) * weights.corrections.col(j);
  }
  return correction;
}

std::unique_ptr<Localiser> MakeFittedLocaliser(LocaliserWeights weights, double finger_radius) {
  return std::make_unique<FittedLocaliser>(std::move(weights), finger_radius);
}

}  // namespace palpate
