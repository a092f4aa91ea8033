// What vision costs: the tip's window, a whole image, and an image behind a JPEG decoder against
// the bare decoder. Decoded grey 640 x 480 pictures in memory, one thread.
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/frame_source.h"
#include "slave/capture/picture_files.h"
#include "slave/vision/ncc.h"
#include "slave/vision/stereo/lens_warp.h"
#include "slave/vision/tip_and_contour_tracker.h"
#include "slave/vision/tip_tracker.h"
#include "tests/slave/vision/test_pictures.h"

namespace palpate {
namespace {

constexpr int kPictures = 16;

// The tool moves a pixel per picture, to and fro; the noise is new in each.
TestPicture PictureAt(int k) {
  TestPicture picture;
  picture.body.emplace();
  picture.tool.emplace();
  picture.tool->tip = {320.3, 150.4 + std::abs(k - kPictures / 2)};
  return picture;
}

const std::vector<cv::Mat>& Pictures() {
  static const std::vector<cv::Mat> pictures = [] {
    std::vector<cv::Mat> rendered;
    for (int k = 0; k < kPictures; ++k) {
      rendered.push_back(PictureAt(k).Render(static_cast<std::uint64_t>(k + 1)));
    }
    return rendered;
  }();
  return pictures;
}

GreyPatch Template(const GreyFormat& format) {
  return CutTipTemplate(Pictures()[0], format, PictureAt(0).tool->tip, {0, 1}, 17, 64).pixels;
}

void NccOf64Window(benchmark::State& state) {
  const GreyFormat format(Pictures()[0]);
  Ncc ncc(Template(format));
  GreyPatch window;
  format.Read(Pictures()[1], {288, 100, 64, 64}, window);
  for (auto _ : state) benchmark::DoNotOptimize(ncc.Match(window).data);
}
BENCHMARK(NccOf64Window);

void Process(benchmark::State& state) {
  TipAndContourTracker tracker(SceneForTestPictures(), Pictures()[0], PictureAt(0).tool->tip);
  std::size_t k = 0;
  std::int64_t lost = 0;
  for (auto _ : state) {
    const Observation& seen = tracker.Process(Pictures()[k % kPictures], k, {});
    ++k;
    lost += seen.tip.found ? 0 : 1;
  }
  state.counters["lost"] = static_cast<double>(lost);
  state.counters["pictures/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(Process);

// JPEG files of the pictures, gone afterwards.
class Recording {
 public:
  static constexpr int kFiles = 200;
  Recording() : folder_(std::filesystem::temp_directory_path() / "palpate-bench-vision") {
    std::filesystem::create_directories(folder_);
    for (int k = 0; k < kFiles; ++k) {
      cv::imwrite(File(k).string(), Pictures()[static_cast<std::size_t>(k) % kPictures]);
    }
  }
  ~Recording() { std::filesystem::remove_all(folder_); }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  [[nodiscard]] std::filesystem::path File(int k) const {
    return folder_ / (std::to_string(k) + ".jpg");
  }
  [[nodiscard]] Scene MakeScene() const {
    Scene scene = SceneForTestPictures();
    scene.file = folder_ / "scene.yaml";
    scene.sense.Find<Camera>()->source = Camera::Source::kFiles;
    scene.sense.Find<Camera>()->pattern = "%d.jpg";
    return scene;
  }

 private:
  std::filesystem::path folder_;
};

void BareDecode(benchmark::State& state) {
  const Recording recording;
  for (auto _ : state) {
    for (int k = 0; k < Recording::kFiles; ++k) {
      benchmark::DoNotOptimize(cv::imread(recording.File(k).string(), cv::IMREAD_UNCHANGED).data);
    }
  }
  state.counters["pictures/s"] = benchmark::Counter(
      static_cast<double>(state.iterations() * Recording::kFiles), benchmark::Counter::kIsRate);
}
BENCHMARK(BareDecode)->Unit(benchmark::kMillisecond)->UseRealTime();

void DecodeAndLook(benchmark::State& state) {
  const Recording recording;
  const Scene scene = recording.MakeScene();
  TipAndContourTracker tracker(scene, Pictures()[0], PictureAt(0).tool->tip);
  for (auto _ : state) {
    const auto source = OpenFrameSource(scene, false);
    while (const auto frame = source->Next({})) {
      benchmark::DoNotOptimize(
          tracker.Process(frame->image, frame->sequence, frame->sensed_at).tip.score);
    }
  }
  state.counters["pictures/s"] = benchmark::Counter(
      static_cast<double>(state.iterations() * Recording::kFiles), benchmark::Counter::kIsRate);
}
BENCHMARK(DecodeAndLook)->Unit(benchmark::kMillisecond)->UseRealTime();

// What a camera's lens costs per picture, beside a blur of 3 x 3, which reads and writes as much.
void StraightenPicture(benchmark::State& state) {
  const Lens lens{800, 800, 320, 240, {-0.25, 0.08, 0.001, -0.0005, 0}, {640, 480}};
  const LensWarp warp = LensWarp::Straightening(lens);
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(warp.Apply(Pictures()[k++ % kPictures]).data);
}
BENCHMARK(StraightenPicture)->Unit(benchmark::kMicrosecond);

void BlurPicture(benchmark::State& state) {
  std::size_t k = 0;
  for (auto _ : state) {
    cv::Mat blurred;
    cv::blur(Pictures()[k++ % kPictures], blurred, {3, 3});
    benchmark::DoNotOptimize(blurred.data);
  }
}
BENCHMARK(BlurPicture)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
