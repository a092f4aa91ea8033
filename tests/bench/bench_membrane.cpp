// From pictures of the membrane's dots to the force, on decoded 640 x 480 pairs in memory, one
// thread, CPU time: pairs per second, against a bare threshold pass over the same two pictures, and
// with the force's error beside. The pictures are of the von Karman plate of 18th order pressed 0
// to 5 mm (`plate`: of the small-deflection plate, 0 to 0.4 mm), noise 2 of 255, blur 0.7 px.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "slave/pipeline/points/surface_estimator.h"
#include "slave/vision/dots/stereo_dots.h"
#include "tests/slave/pipeline/points/membrane_scene.h"
#include "tests/slave/vision/dots/dot_pictures.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing_fakes::kModulus;
using testing_fakes::kNu;
using testing_fakes::kRadius;
using testing_fakes::kThickness;
using testing_fakes::kToolWidth;
using testing_fakes::MembraneScene;

constexpr int kPictures = 24;
constexpr double kDotRadius = 0.002;
const Vector2d kPlace(0.0117, 0);

struct Pair {
  cv::Mat left, right;
  double force = 0;  // of the membrane on the tool [N]
};

Pair RenderPair(PlateSurface& plate, double depth, std::uint64_t seed) {
  const Contact contact{
      .p_O = {kPlace.x(), kPlace.y(), 0}, .width = kToolWidth, .prescribed_O = {0, 0, -depth}};
  Solution solution;
  plate.Solve({&contact, 1}, &solution);
  std::vector<Vector3d> places, normals;
  for (const Vector2d& p : LatticePlaces(31, {0.015, 0.010})) {
    const double h = 1e-4, w = depth > 0 ? plate.Displacement(solution, p) : 0;
    const auto slope = [&](const Vector2d& step) {
      return depth > 0 ? (plate.Displacement(solution, p + h * step) - w) / h : 0;
    };
    places.emplace_back(p.x(), p.y(), w);
    normals.push_back(Vector3d(-slope({1, 0}), -slope({0, 1}), 1).normalized());
  }
  Pair pair;
  pair.force = -solution.responses()[0].force_O.z();
  for (const int eye : {0, 1}) {
    DotPicture picture;
    picture.light_fall = 0.15;
    picture.dots = ArraySeen(eye, places, normals, kDotRadius);
    (eye == 0 ? pair.left : pair.right) = picture.Render(2 * seed + static_cast<unsigned>(eye));
  }
  return pair;
}

// The tool goes in and out again, a picture each 2 kPictures-th of the way.
std::vector<Pair> RenderPairs(const std::string& kind) {
  std::unique_ptr<PlateSurface> plate;
  double deepest = 5e-3;
  if (kind == "plate") {
    plate =
        std::make_unique<PlateModel>(PlateModel::Params{kRadius, kThickness, kModulus, kNu, 0.5});
    deepest = 4e-4;
  } else {
    plate = std::make_unique<PlateLargeModel>(
        PlateLargeModel::Params{kRadius, kThickness, kModulus, kNu, 0, 18});
  }
  std::vector<Pair> pairs;
  for (int k = 0; k < kPictures; ++k) {
    const double share = 1 - std::abs(2.0 * k / kPictures - 1);
    pairs.push_back(RenderPair(*plate, deepest * share, static_cast<std::uint64_t>(k)));
  }
  return pairs;
}

const std::vector<Pair>& PairsOf(const std::string& kind) {
  static const std::vector<Pair> small = RenderPairs("plate"), large = RenderPairs("plate-large");
  return kind == "plate" ? small : large;
}

// The reference: one comparison and one addition per pixel of both pictures.
void BareThreshold(benchmark::State& state) {
  const std::vector<Pair>& pairs = PairsOf("plate");
  std::size_t k = 0;
  for (auto _ : state) {
    int dark = 0;
    for (const cv::Mat* image : {&pairs[k % pairs.size()].left, &pairs[k % pairs.size()].right}) {
      for (int y = 0; y < image->rows; ++y) {
        const std::uint8_t* row = image->ptr<std::uint8_t>(y);
        for (int x = 0; x < image->cols; ++x) dark += row[x] < 115 ? 1 : 0;
      }
    }
    benchmark::DoNotOptimize(dark);
    ++k;
  }
  state.counters["pairs"] = benchmark::Counter(static_cast<double>(k), benchmark::Counter::kIsRate);
}
BENCHMARK(BareThreshold);

StereoDots TipAndContourTracker(DotTracker::Search search) {
  StereoDots::Params params;
  params.rig = TestRig();
  params.X_SL = TestPoseOfLeft();
  params.layout = LatticePlaces(31, {0.015, 0.010});
  params.dot_radius = kDotRadius;
  params.search = search;
  return StereoDots(params);
}

// Counters: `pairs` per second; `rms_share` and `worst_share`, the force's error by the largest
// force; `unknown` pictures without one.
void DotsToForce(benchmark::State& state, const std::string& kind, DotTracker::Search search) {
  const std::vector<Pair>& pairs = PairsOf(kind);
  StereoDots eyes = TipAndContourTracker(search);
  SurfaceEstimator estimator(MembraneScene(kind));
  while (!eyes.at_rest_known()) eyes.Observe(pairs[0].left, pairs[0].right, Time{});
  double largest = 0;
  for (const Pair& pair : pairs) largest = std::max(largest, pair.force);
  std::size_t k = 0;
  double squares = 0, worst = 0;
  int unknown = 0;
  for (auto _ : state) {
    const Pair& pair = pairs[k % pairs.size()];
    const ContactEstimate& felt =
        estimator.Estimate(eyes.Observe(pair.left, pair.right, Time{}), {0.01, 0, 0.01});
    ++k;
    if (!felt.force) {
      ++unknown;
      continue;
    }
    const double error = felt.force->norm() - pair.force;
    squares += error * error;
    worst = std::max(worst, std::abs(error));
  }
  state.counters["pairs"] = benchmark::Counter(static_cast<double>(k), benchmark::Counter::kIsRate);
  state.counters["rms_share"] = std::sqrt(squares / static_cast<double>(k)) / largest;
  state.counters["worst_share"] = worst / largest;
  state.counters["unknown"] = unknown;
}
BENCHMARK_CAPTURE(DotsToForce, plate_tracked, "plate", DotTracker::Search::kNear);
BENCHMARK_CAPTURE(DotsToForce, plate_full_search, "plate", DotTracker::Search::kWhole);
BENCHMARK_CAPTURE(DotsToForce, plate_large_tracked, "plate-large", DotTracker::Search::kNear);
BENCHMARK_CAPTURE(DotsToForce, plate_large_full_search, "plate-large", DotTracker::Search::kWhole);

// The force alone: dots' places known.
void PointsToForce(benchmark::State& state, const std::string& kind) {
  SurfaceEstimator estimator(MembraneScene(kind));
  PlateLargeModel plate({kRadius, kThickness, kModulus, kNu, 0, 18});
  std::mt19937 random(1);
  std::vector<SurfaceObservation> seen;
  for (int k = 0; k < kPictures; ++k) {
    const double share = 1 - std::abs(2.0 * k / kPictures - 1);
    const double force = kind == "plate" ? -0.04 * share : -4 * share * share;
    seen.push_back(testing_fakes::DotsUnder(plate, kPlace, force, 2e-5, &random));
  }
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(estimator.Estimate(seen[k % seen.size()], {0, 0, 0.01}).sigma);
    ++k;
  }
}
BENCHMARK_CAPTURE(PointsToForce, plate, "plate");
BENCHMARK_CAPTURE(PointsToForce, plate_large, "plate-large");

// What a state between pictures takes: the contact that the master renders, anywhere.
void LocalContact(benchmark::State& state) {
  SurfaceEstimator estimator(MembraneScene("plate-large"));
  double x = 0;
  for (auto _ : state) {
    x = x > 0.03 ? -0.03 : x + 1e-4;
    benchmark::DoNotOptimize(estimator.LocalAt({x, 0.5 * x, -0.002 + 0.03 * x}).revision);
  }
}
BENCHMARK(LocalContact);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
