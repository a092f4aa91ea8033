// The whole way from a picture to a force: tip, snake, contact and capacitance matrix, over the
// pictures of a scripted press of the block; and `process` over JPEG files beside bare decoding.
#include <chrono>
#include <filesystem>
#include <fstream>

#include <benchmark/benchmark.h>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

#include "slave/capture/codecs/codecs.h"
#include "slave/pipeline/camera/estimator.h"
#include "slave/pipeline/offline/offline_run.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/camera/simulated_site.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

Scene Block(int elements) {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"));
  scene.model.elements = elements;
  return scene;
}

const std::vector<Frame>& Press() {
  static const std::vector<Frame> frames = [] {
    SimulatedSite site(Block(180));
    const auto camera = site.OpenCamera(Block(180), {.is_live = false});
    std::vector<Frame> all;
    while (std::optional<Frame> frame = camera->Next({})) all.push_back(*frame);
    return all;
  }();
  return frames;
}

// Decoded grey 640x480 pictures in memory -> force. items_per_second: pictures.
void PictureToForce(benchmark::State& state) {
  const Scene scene = Block(static_cast<int>(state.range(0)));
  const std::vector<Frame>& frames = Press();
  Estimator estimator(scene, frames.front(), scene.manipulator.home);
  std::size_t next = 0;
  std::uint64_t lost = 0;
  for (auto _ : state) {
    const ContactEstimate& estimate = estimator.Estimate(frames[next]);
    lost += estimate.validity == Validity::kTrackingLost ? 1 : 0;
    next = (next + 1) % frames.size();
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["lost"] = static_cast<double>(lost);
  state.counters["dof"] = static_cast<double>(estimator.touch().deformation->info().dof);
}
BENCHMARK(PictureToForce)->Arg(60)->Arg(180)->Arg(500)->Unit(benchmark::kMicrosecond);

// A folder of JPEG files, removed at the end.
class JpegFolder {
 public:
  explicit JpegFolder(int rounds)
      : path_(fs::temp_directory_path() / ("bench-" + std::to_string(getpid()))) {
    fs::create_directories(path_);
    for (int round = 0; round < rounds; ++round) {
      for (const Frame& frame : Press()) {
        const fs::path file = path_ / (std::to_string(100000 + count_++) + ".jpg");
        std::ofstream(file, std::ios::binary) << EncodeJpeg(frame.image, 90);
      }
    }
  }
  ~JpegFolder() { fs::remove_all(path_); }
  JpegFolder(const JpegFolder&) = delete;
  JpegFolder& operator=(const JpegFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }
  [[nodiscard]] int count() const { return count_; }

 private:
  fs::path path_;
  int count_ = 0;
};

double SecondsToDecode(const fs::path& folder) {
  std::vector<cv::String> files;
  cv::glob((folder / "*.jpg").string(), files);
  const auto began = std::chrono::steady_clock::now();
  for (const cv::String& file : files) {
    benchmark::DoNotOptimize(cv::imread(file, cv::IMREAD_UNCHANGED).data);
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

// `process` over JPEG files. of_bare_decode: its rate as a share of decoding the same files and
// nothing else.
void ProcessJpegFiles(benchmark::State& state) {
  const JpegFolder folder(4);
  Scene scene = Block(180);
  const fs::path template_file = folder.path() / "tip.png";
  const cv::Rect window(311, 62, 20, 58);  // the tool's end in the first picture, above the block
  cv::imwrite(template_file.string(), Press().front().image(window));
  scene.sense.Find<Camera>()->source = Camera::Source::kFiles;
  scene.sense.Find<Camera>()->pattern = (folder.path() / "*.jpg").string();
  scene.sense.Find<TipTracking>()->template_file = template_file;
  OfflineOptions run;
  run.out = folder.path() / "out";
  double share = 0;
  for (auto _ : state) {
    const double bare = SecondsToDecode(folder.path());
    const OfflineSummary summary = RunOffline(scene, run, {});
    share = bare / summary.seconds;
    state.counters["lost"] = static_cast<double>(summary.tracking_lost);
  }
  state.SetItemsProcessed(state.iterations() * folder.count());
  state.counters["of_bare_decode"] = share;
}
BENCHMARK(ProcessJpegFiles)->Unit(benchmark::kMillisecond)->Iterations(3);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
