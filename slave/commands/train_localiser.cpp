#include "slave/commands/train_localiser.h"

#include <cstdio>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/training/normal_axes.h"
#include "slave/tactile/training/normal_errors.h"
#include "slave/tactile/training/recorded_normals.h"

namespace palpate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFingerRadius = 7e-3;  // [m]; directions do not depend on it

struct Samples {
  std::vector<TactileSignals> change;
  std::vector<Eigen::Vector3d> normals;
};

Samples Read(std::span<const std::string> arguments, const TrainOptions& options) {
  Samples samples;
  for (const std::string& argument : arguments) {
    const ContactNormals some =
        ReadContactNormals(ParseDataArgument(argument), options.finger, options.contact_pdc);
    std::printf("%s: %zu samples in contact, pdc above %.0f\n", argument.c_str(),
                some.change.size(), some.contact_pdc);
    samples.change.insert(samples.change.end(), some.change.begin(), some.change.end());
    samples.normals.insert(samples.normals.end(), some.normals.begin(), some.normals.end());
  }
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

void Print(const char* what, const LocaliserWeights& weights, const Samples& samples) {
  const NormalErrors errors =
      CompareNormals(*MakeFittedLocaliser(weights, kFingerRadius), samples.change, samples.normals);
  std::printf("%s: median angle %.2f deg, %.2f deg after the best rotation, %zu of %zu found\n",
              what, errors.median / kDegree, errors.aligned_median / kDegree, errors.found,
              samples.change.size());
}

ElectrodeLayout LayoutOf(const TrainOptions& options) {
  if (!options.electrodes.empty()) return ReadElectrodeLayout(options.electrodes);
  std::printf("electrodes where the simulated fingertip has them (--electrodes names others)\n");
  return SimulatedLayout(kFingerRadius);
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
  Print("first half fitted, second half tested", fit(first), second);
  Print("second half fitted, first half tested", fit(second), first);
  const LocaliserWeights weights = fit(lesson.data);
  if (!options.test.empty()) Print("all fitted, test recordings", weights, lesson.test);
  const std::filesystem::path file = options.out / "localiser.json";
  WriteLocaliser(weights, file);
  std::printf("%s: %d samples, %.2f deg where left out\n", file.c_str(), weights.samples,
              weights.median_error / kDegree);
  return 0;
}

}  // namespace palpate
