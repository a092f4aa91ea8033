// What following a window of texture costs: 640 x 480 grey pictures in memory, one thread. The
// reference is a bare sum of squared differences over the same 31 x 31 pixels, once.
#include <cmath>
#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>

#include "slave/vision/texture/ssd_tracker.h"
#include "slave/vision/texture/stereo_texture.h"
#include "tests/slave/vision/texture/target_pictures.h"

namespace palpate {
namespace {

constexpr int kWindows = 25;

std::vector<Eigen::Vector2d> Grid() {
  std::vector<Eigen::Vector2d> at;
  for (int i = 0; i < kWindows; ++i) at.emplace_back(290 + 15 * (i % 5), 210 + 15 * (i / 5));
  return at;
}

// The body goes to and fro by a millimetre and a half a picture, as fast as 52 mm/s at 30 Hz.
const std::vector<TargetPictures::Pair>& Pairs() {
  static const std::vector<TargetPictures::Pair> pairs = [] {
    TargetPictures pictures;
    std::vector<TargetPictures::Pair> taken;
    for (const int k : {0, 1, 2, 3, 2, 1})
      taken.push_back(pictures.Take({0.0015 * k, 0, 0.0005 * k}));
    return taken;
  }();
  return pairs;
}

void BareDifferences(benchmark::State& state) {
  const cv::Mat &a = Pairs()[0].left, &b = Pairs()[1].left;
  for (auto _ : state) {
    for (const Eigen::Vector2d& p : Grid()) {
      int sum = 0;
      for (int v = -15; v <= 15; ++v) {
        const auto* one =
            a.ptr<std::uint8_t>(static_cast<int>(p.y()) + v) + static_cast<int>(p.x());
        const auto* two =
            b.ptr<std::uint8_t>(static_cast<int>(p.y()) + v) + static_cast<int>(p.x());
        for (int u = -15; u <= 15; ++u) sum += (one[u] - two[u]) * (one[u] - two[u]);
      }
      benchmark::DoNotOptimize(sum);
    }
  }
  state.SetItemsProcessed(state.iterations() * kWindows);
}
BENCHMARK(BareDifferences);

void FollowWindows(benchmark::State& state) {
  SsdTracker tracker(Pairs()[0].left, Grid(), {});
  std::size_t k = 0;
  long seen = 0;
  for (auto _ : state) {
    for (const TrackedWindow& window : tracker.Track(Pairs()[++k % Pairs().size()].left)) {
      seen += window.seen();
    }
  }
  state.SetItemsProcessed(state.iterations() * kWindows);
  state.counters["seen"] =
      static_cast<double>(seen) / static_cast<double>(state.iterations() * kWindows);
}
BENCHMARK(FollowWindows);

void FollowPairs(benchmark::State& state) {
  const TargetPictures pictures;
  StereoTextureOptions options;
  options.at = Grid();
  StereoTexture texture(pictures.rig, pictures.X_SL, options);
  std::size_t k = 0;
  double square = 0, count = 0;
  texture.Process(Pairs()[0].left, Pairs()[0].right, 0, Time{});
  for (auto _ : state) {
    const auto& pair = Pairs()[++k % Pairs().size()];
    const SurfaceObservation& seen = texture.Process(pair.left, pair.right, k, Time{});
    const int step = std::vector{0, 1, 2, 3, 2, 1}[k % Pairs().size()];
    for (const SurfacePoint& point : seen.points) {
      if (!point.seen) continue;
      const Eigen::Vector3d moved(0.0015 * step, 0, 0.0005 * step);
      square += (point.p_S - point.p_S_rest - moved).squaredNorm();
      ++count;
    }
  }
  state.SetItemsProcessed(state.iterations() * kWindows * 2);
  state.counters["rms_mm"] = 1e3 * std::sqrt(square / count);
  state.counters["seen"] = count / static_cast<double>(state.iterations() * kWindows);
}
BENCHMARK(FollowPairs);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
