// Tests the latency measured from the light: a lamp that is switched at known times lights the
// camera's images. The test compares these times with the traces' exposure time of each image.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/capture/codecs/codecs.h"
#include "slave/live/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/simulator/simulated_devices.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

constexpr double kSpan = 0.05;  // of the lamp, three images [s]
constexpr std::size_t kLightImages = 60;
constexpr double kTimeout = 60;  // [s]

bool IsDimAt(Time at) {
  return std::fmod(SecondsBetween(Time{}, at) / kSpan, 2) >= 1;
}

double LevelOf(const std::string& jpeg) {
  const auto coded = OpenJpeg({reinterpret_cast<const unsigned char*>(jpeg.data()), jpeg.size()});
  return cv::mean(coded->Decode())[0];
}

struct Sighting {
  double level;
  bool is_marked_dim;
};

// Images, and the traces of the same instant.
std::vector<Sighting> Watch(Slave* slave) {
  std::vector<Sighting> seen;
  Time last{};
  for (const Time begin = Clock::now(); seen.size() < kLightImages;) {
    if (SecondsBetween(begin, Clock::now()) > kTimeout) break;
    slave->WaitForNewer(last, std::chrono::milliseconds(50));
    const auto image = slave->Image(false, 90);
    for (const SampleTrace& trace : slave->TracesSince(last)) {
      last = trace.sensed_at;
      EXPECT_LE(trace.sensed_at, trace.acquired_at);
      EXPECT_LE(trace.acquired_at, trace.processed_at);
      EXPECT_LE(trace.processed_at, trace.solved_at);
      if (!image || image->sensed_at != trace.sensed_at) continue;
      seen.push_back({LevelOf(image->jpeg), IsDimAt(trace.sensed_at)});
    }
  }
  return seen;
}

// Reference: the switching times of the lamp. A timestamp of another image (such as the previous
// one) would be wrong for one image in three. A busy machine that stops a thread between timestamp
// and exposure may cause a few errors.
TEST(LightTest, ATraceHasTheExposureTimeOfItsImage) {
  const Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"),
                                {"model.elements=60", "site.lamp=50 ms", "site.flicker=0"});
  const auto slave = MakeLiveSlave(scene);
  const SimulatedDevices devices(scene, slave.get());
  const std::vector<Sighting> seen = Watch(slave.get());
  ASSERT_EQ(seen.size(), kLightImages);
  const auto [dimmest, brightest] = std::ranges::minmax(seen, {}, &Sighting::level);
  ASSERT_GT(brightest.level - dimmest.level, 0.05 * brightest.level) << "the lamp never switched";
  const double between = (dimmest.level + brightest.level) / 2;
  const auto wrong = std::ranges::count_if(
      seen, [&](const Sighting& one) { return (one.level < between) != one.is_marked_dim; });
  EXPECT_LE(wrong, static_cast<std::ptrdiff_t>(kLightImages / 10));
}

}  // namespace
}  // namespace palpate
