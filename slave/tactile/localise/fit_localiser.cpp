// The fit itself: kernel ridge regression of what the formula leaves of the measured normals.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "slave/tactile/localise/direction_mean.h"
#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/localise/intensity.h"
#include "slave/tactile/localise/normal_correction.h"

namespace palpate {
namespace {

// Weights of the ridge to choose from; the kernel of a sample with itself is 1. The least stands
// where stretches of one recording still profit from less: another recording would not.
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
  if (options.centres < 1 || options.centres > kMostLocaliserCentres) {
    Refuse("centres = " + std::to_string(options.centres) + ": accepted is 1 to " +
           std::to_string(kMostLocaliserCentres));
  }
  if (options.folds < 2 || options.folds > 20) {
    Refuse("folds = " + std::to_string(options.folds) + ": accepted is 2 to 20");
  }
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

// The rotation R with the least sum of |measured - R formula|^2 (Kabsch 1976).
Eigen::Matrix3d BestRotation(const Samples& samples) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  for (const Sample& s : samples) H += s.measured * s.formula.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
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
  weights->R = BestRotation(samples);
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

}  // namespace

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

}  // namespace palpate
