// What two eyes on an array of dots cost, on decoded 640 x 480 pairs in memory, one thread: against
// a bare threshold pass over the same two pictures, and with the error of what is seen beside.
#include <cmath>
#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/dots/dot_tracker.h"
#include "slave/vision/dots/stereo_dots.h"
#include "tests/slave/vision/dots/dot_pictures.h"

namespace palpate {
namespace {

constexpr int kPictures = 16;
constexpr double kRadius = 0.002;  // of a dot [m]

struct Pair {
  cv::Mat left, right;
};

// The flat array goes towards the cameras and back, half a millimetre a picture.
double DepthAt(int k) {
  return 0.0005 * (k < kPictures / 2 ? k : kPictures - k);
}

const std::vector<Eigen::Vector2d>& Layout() {
  static const auto layout = LatticePlaces(31, {0.015, 0.010});
  return layout;
}

const std::vector<Pair>& Pairs() {
  static const std::vector<Pair> pairs = [] {
    std::vector<Pair> rendered(kPictures);
    for (int k = 0; k < kPictures; ++k) {
      std::vector<Eigen::Vector3d> places, normals(Layout().size(), {0, 0, 1});
      for (const Eigen::Vector2d& p : Layout()) places.emplace_back(p.x(), p.y(), -DepthAt(k));
      for (const int eye : {0, 1}) {
        DotPicture picture;
        picture.light_fall = 0.15;
        picture.dots = ArraySeen(eye, places, normals, kRadius);
        Pair& pair = rendered[static_cast<std::size_t>(k)];
        (eye == 0 ? pair.left : pair.right) =
            picture.Render(static_cast<std::uint64_t>(2 * k + eye));
      }
    }
    return rendered;
  }();
  return pairs;
}

const Pair& PairAt(int k) {
  return Pairs()[static_cast<std::size_t>(k % kPictures)];
}

// The reference: one comparison and one addition per pixel of both pictures.
void BareThreshold(benchmark::State& state) {
  int k = 0;
  for (auto _ : state) {
    int dark = 0;
    for (const cv::Mat* image : {&PairAt(k).left, &PairAt(k).right}) {
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

void FindInBoth(benchmark::State& state) {
  DotFinder finder(DotFinder::Params{});
  std::vector<Dot> dots;
  int k = 0;
  for (auto _ : state) {
    finder.Find(PairAt(k).left, &dots);
    finder.Find(PairAt(k).right, &dots);
    ++k;
  }
  state.counters["pairs"] = benchmark::Counter(static_cast<double>(k), benchmark::Counter::kIsRate);
  state.counters["dots"] = static_cast<double>(dots.size());
}
BENCHMARK(FindInBoth);

void Stereo(benchmark::State& state, DotTracker::Search search) {
  StereoDots::Params params;
  params.rig = TestRig();
  params.X_SL = TestPoseOfLeft();
  params.layout = Layout();
  params.dot_radius = kRadius;
  params.search = search;
  StereoDots eyes(params);
  for (int k = 0; k < params.rest_pictures; ++k) {
    eyes.Observe(PairAt(0).left, PairAt(0).right, Time{});
  }
  int k = 0;
  double squares = 0, seen = 0;
  for (auto _ : state) {
    const SurfaceObservation& observed = eyes.Observe(PairAt(k).left, PairAt(k).right, Time{});
    for (const SurfacePoint& point : observed.points) {
      if (!point.seen) continue;
      const double depth = DepthAt(k % kPictures);
      squares += (point.p_S - point.p_S_rest - Eigen::Vector3d(0, 0, -depth)).squaredNorm();
      ++seen;
    }
    ++k;
  }
  state.counters["pairs"] = benchmark::Counter(static_cast<double>(k), benchmark::Counter::kIsRate);
  state.counters["dots"] = seen / k;
  state.counters["rms_um"] = 1e6 * std::sqrt(squares / seen);
}
BENCHMARK_CAPTURE(Stereo, tracked, DotTracker::Search::kNear);
BENCHMARK_CAPTURE(Stereo, full_search, DotTracker::Search::kWhole);

// The array is looked for from nothing.
void MatchFirst(benchmark::State& state) {
  DotFinder finder(DotFinder::Params{});
  std::vector<Dot> dots;
  finder.Find(PairAt(0).left, &dots);
  DotArray array(Layout(), {});
  std::vector<int> picks;
  int found = 0;
  for (auto _ : state) found = array.Match(dots, {}, &picks);
  state.counters["dots"] = found;
}
BENCHMARK(MatchFirst);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
