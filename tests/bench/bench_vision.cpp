// What the correction of a lens costs. Grey 640 x 480 pictures in memory, one thread.
#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

// The content does not matter: each pixel is read and written once.
cv::Mat Picture() {
  cv::Mat picture(480, 640, CV_8UC1);
  cv::randu(picture, 0, 256);
  return picture;
}

// What a camera's lens costs per picture, beside a blur of 3 x 3, which reads and writes as much.
void StraightenPicture(benchmark::State& state) {
  const Lens lens{800, 800, 320, 240, {-0.25, 0.08, 0.001, -0.0005, 0}, {640, 480}};
  const LensWarp warp = LensWarp::Straightening(lens);
  const cv::Mat picture = Picture();
  for (auto _ : state) benchmark::DoNotOptimize(warp.Apply(picture).data);
}
BENCHMARK(StraightenPicture)->Unit(benchmark::kMicrosecond);

void BlurPicture(benchmark::State& state) {
  const cv::Mat picture = Picture();
  for (auto _ : state) {
    cv::Mat blurred;
    cv::blur(picture, blurred, {3, 3});
    benchmark::DoNotOptimize(blurred.data);
  }
}
BENCHMARK(BlurPicture)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
