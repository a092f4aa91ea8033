#include <algorithm>
#include <cstdio>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "slave/commands/train/train_data.h"
#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/recordings/recordings.h"
#include "slave/tactile/training/estimate_errors.h"

namespace palpate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLargestMedian = 12 * kDegree;  // the paper's formula alone is at 8
constexpr double kFingerRadius = 7e-3;           // [m]; directions do not depend on it

struct Samples {
  std::vector<TactileSignals> change;
  std::vector<Eigen::Vector3d> normals;
};

ContactNormals ReadContacts(const std::string& argument, const TrainOptions& options) {
  ContactNormals some =
      ReadContactNormals(ParseDataArgument(argument), options.finger, options.contact_pdc);
  if (some.change.empty()) {
    throw std::runtime_error(
        fmt::format("{}: no sample in contact, pdc above {:.0f}", argument, some.contact_pdc));
  }
  std::printf("%s: %zu samples in contact, pdc above %.0f\n", argument.c_str(), some.change.size(),
              some.contact_pdc);
  return some;
}

// What can be used of these files.
Samples Read(std::span<const std::string> arguments, const TrainOptions& options) {
  Samples samples;
  std::string refused;
  for (const std::string& argument : arguments) {
    try {
      const ContactNormals some = ReadContacts(argument, options);
      samples.change.insert(samples.change.end(), some.change.begin(), some.change.end());
      samples.normals.insert(samples.normals.end(), some.normals.begin(), some.normals.end());
    } catch (const std::runtime_error& e) {
      if (!refused.empty()) refused += "\n";
      refused += e.what();
    }
  }
  if (refused.empty()) return samples;
  if (samples.change.empty()) throw std::invalid_argument(refused);
  std::fprintf(stderr, "train: warning: not used: %s\n", refused.c_str());
  return samples;
}

Samples Part(const Samples& samples, std::size_t begin, std::size_t end) {
  const auto from = static_cast<std::ptrdiff_t>(begin), to = static_cast<std::ptrdiff_t>(end);
  return {{samples.change.begin() + from, samples.change.begin() + to},
          {samples.normals.begin() + from, samples.normals.begin() + to}};
}

void Turn(const Eigen::Matrix3d& axes, Samples* samples) {
  for (Eigen::Vector3d& n : samples->normals) n = axes * n;
}

// Throws std::invalid_argument: nothing was found in any sample.
NormalErrors Test(const char* what, const LocaliserWeights& weights, const Samples& samples) {
  const NormalErrors errors =
      CompareNormals(*MakeFittedLocaliser(weights, kFingerRadius), samples.change, samples.normals);
  if (errors.found == 0) {
    throw std::invalid_argument(
        fmt::format("{}: no contact found in any of {} samples", what, samples.change.size()));
  }
  std::printf("%s: median angle %.2f deg, %.2f deg after the best rotation, %zu of %zu found\n",
              what, errors.median / kDegree, errors.aligned_median / kDegree, errors.found,
              samples.change.size());
  return errors;
}

// Half of the recording, fitted to the other half, must tell where the other one is touched. What
// does not is a formula for another sensor: electrodes that lie elsewhere, normals that are not
// those of the contact.
void RefuseNonsense(const NormalErrors& one, const NormalErrors& other) {
  if (std::min(one.median, other.median) <= kLargestMedian) return;
  throw std::invalid_argument(fmt::format(
      "nothing written: neither half of the data predicts the normals of the other half (median "
      "angles {:.1f} and {:.1f} deg; accepted is {:g} deg in one of them). Check that --electrodes "
      "belongs to this sensor, that nx, ny, nz are contact normals, and --normals",
      one.median / kDegree, other.median / kDegree, kLargestMedian / kDegree));
}

ElectrodeLayout LayoutOf(const TrainOptions& options) {
  if (options.electrodes == "simulated") return SimulatedLayout(kFingerRadius);
  if (!options.electrodes.empty()) return ReadElectrodeLayout(options.electrodes);
  throw std::invalid_argument(
      "--network localiser: needs the electrode positions: accepted is --electrodes FILE with rows "
      "NAME,x,y,z,nx,ny,nz in mm, or --electrodes simulated for the simulated fingertip");
}

// Turns the measured normals into frame F, as the options say or as the formula finds it.
Eigen::Matrix3d ChooseAxes(const TrainOptions& options, const Samples& samples,
                           const ElectrodeLayout& layout) {
  if (options.normals != "auto") return ParseAxes(options.normals);
  const LocaliserWeights raw = FitLocaliser(samples.change, samples.normals, layout, {});
  return NearestAxes(raw.R.transpose());
}

struct Lesson {
  ElectrodeLayout layout;
  Samples data, test;
};

Lesson Prepare(const TrainOptions& options) {
  try {
    Lesson lesson{LayoutOf(options), Read(options.data, options), Read(options.test, options)};
    const Eigen::Matrix3d axes = ChooseAxes(options, lesson.data, lesson.layout);
    std::printf("normals in frame F: %s of the recording\n", AxesText(axes).c_str());
    Turn(axes, &lesson.data);
    Turn(axes, &lesson.test);
    return lesson;
  } catch (const std::runtime_error& e) {
    throw std::invalid_argument(e.what());
  }
}

}  // namespace

int TrainLocaliser(const TrainOptions& options) {
  const Lesson lesson = Prepare(options);
  const auto fit = [&](const Samples& samples) {
    return FitLocaliser(samples.change, samples.normals, lesson.layout, {});
  };
  const std::size_t all = lesson.data.change.size();
  const Samples first = Part(lesson.data, 0, all / 2), second = Part(lesson.data, all / 2, all);
  const NormalErrors ahead = Test("first half fitted, second half tested", fit(first), second);
  const NormalErrors back = Test("second half fitted, first half tested", fit(second), first);
  RefuseNonsense(ahead, back);
  const LocaliserWeights weights = fit(lesson.data);
  if (!options.test.empty()) Test("all fitted, test recordings", weights, lesson.test);
  const std::filesystem::path file = options.out / "localiser.json";
  WriteLocaliser(weights, file);
  std::printf("%s: %d samples, %.2f deg in cross-validation\n", file.c_str(), weights.samples,
              weights.median_error / kDegree);
  return 0;
}

}  // namespace palpate
