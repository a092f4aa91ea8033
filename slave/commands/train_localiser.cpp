#include "slave/commands/train_localiser.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/training/normal_axes.h"
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

// Median angle between found and measured normals [rad]; samples without a place count as 90 deg.
double MedianAngle(const LocaliserWeights& weights, const Samples& samples) {
  const auto localiser = MakeFittedLocaliser(weights, kFingerRadius);
  std::vector<double> angles;
  for (std::size_t k = 0; k < samples.change.size(); ++k) {
    const TouchPlace place = localiser->Locate(samples.change[k], FingerReading{});
    const double cosine = place.usable() ? place.n_F.dot(samples.normals[k]) : 0.0;
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle;
}

ElectrodeLayout LayoutOf(const TrainOptions& options) {
  return options.electrodes.empty() ? SimulatedLayout(kFingerRadius)
                                    : ReadElectrodeLayout(options.electrodes);
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
  std::printf("median angle, first half fitted, second tested: %.2f deg; the other way: %.2f deg\n",
              MedianAngle(fit(first), second) / kDegree, MedianAngle(fit(second), first) / kDegree);
  const LocaliserWeights weights = fit(lesson.data);
  if (!options.test.empty() && !lesson.test.change.empty()) {
    std::printf("median angle on the test recordings: %.2f deg\n",
                MedianAngle(weights, lesson.test) / kDegree);
  }
  const std::filesystem::path file = options.out / "localiser.json";
  WriteLocaliser(weights, file);
  std::printf("%s: %d samples, %.2f deg where left out\n", file.c_str(), weights.samples,
              weights.median_error / kDegree);
  return 0;
}

}  // namespace palpate
