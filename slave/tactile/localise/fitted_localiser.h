// A localiser that is fitted to recordings of one sensor with known contact normals.
//
//   n = R n_0 + sum_j a_j exp(-gamma |u - u_j|^2),   u = changes of the electrodes / (quiet + their
//   norm)
//
// n_0 is the pressure-weighted formula's normal, R the rotation that brings it nearest to the
// measured ones (how the recording's frame lies on the finger), and the sum a correction learnt by
// kernel ridge regression. The kernel is narrow and the regression stiff: signals that resemble
// none it has learnt get the formula's answer.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include <Eigen/Core>

#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/signals/rest_values.h"

namespace palpate {

inline constexpr int kMostLocaliserCentres = 512;  // [-] [tuned: LearnsWhatTheFormulaGetsWrong]

struct LocaliserWeights {
  ElectrodeLayout layout;
  double threshold = 5;                                            // of n_0 [counts]
  double quiet = 20;                                               // [counts]
  double gamma = 5;                                                // [-]
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();                 // rotation
  Eigen::Matrix<double, kElectrodeCount, Eigen::Dynamic> centres;  // u_j, one per column
  Eigen::Matrix<double, 3, Eigen::Dynamic> corrections;            // a_j, frame F
  double sigma_angle = 0;  // within which 68 % of left-out samples are [rad]
  // How the fit went.
  double ridge = 1;         // chosen; the kernel of a sample with itself is 1
  int samples = 0;          // that were in contact
  double median_error = 0;  // of the left-out samples [rad]
};

struct FitLocaliserOptions {
  double threshold = 5;  // change of an active electrode [counts]
  int centres = 300;     // at most, 1 to kMostLocaliserCentres; evenly spaced among the samples
  int folds = 4;         // stretches of time that are left out in turn, 2 to 20
};

// The rotation R with the least sum of |measured - R found|^2, from the sum of measured found^T
// (Kabsch 1976).
Eigen::Matrix3d BestRotation(const Eigen::Matrix3d& measured_by_found);

// Fits to samples in the order of recording: changes (counts minus baseline) and outward unit
// normals of the contact, frame F (n = -(normal of the touched plate); from surface points:
// FingerSurface::Normal). Samples without a contact by the formula are skipped. The stiffness of
// the regression is chosen by cross-validation over stretches of these samples. Deterministic;
// below a second for 10 000 samples. Throws std::invalid_argument: needs as many normals as
// samples, finite, of length 1, and at least ten samples per fold in contact.
LocaliserWeights FitLocaliser(std::span<const TactileSignals> changes,
                              std::span<const Eigen::Vector3d> normals_F,
                              const ElectrodeLayout& layout, const FitLocaliserOptions& options);

// The file of `tactile.localise`: JSON, `format: palpate-localiser/1`, members as above, rows of
// matrices as lists. Throws std::runtime_error `file: error`.
void WriteLocaliser(const LocaliserWeights& weights, const std::filesystem::path& file);
LocaliserWeights ReadLocaliser(const std::filesystem::path& file);

// Throws std::invalid_argument: an electrode on the finger's axis.
std::unique_ptr<Localiser> MakeFittedLocaliser(LocaliserWeights weights, double finger_radius);

// Shared by fitting and locating. u: pattern of the electrode changes, independent of their
// magnitude.
using SignalShape = Eigen::Matrix<double, kElectrodeCount, 1>;

SignalShape ShapeOf(const TactileSignals& change, double quiet) noexcept;

// sum_j a_j exp(-gamma |u - u_j|^2). Allocation-free.
Eigen::Vector3d Correction(const LocaliserWeights& weights, const SignalShape& u) noexcept;

}  // namespace palpate
