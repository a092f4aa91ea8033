// Sends tactile samples to a slave: feed_tactile HOST:PORT. Every fingertip of the scene rests for
// half a second. A sample with 18 electrodes follows, which must be rejected with an explanation.
// Prints the number of accepted samples. Exit code 0: all.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <palpate/client.h>

palpate::v1::TactileSample Rest(std::uint64_t sequence, const std::string& finger, int electrodes) {
  palpate::v1::TactileSample sample;
  sample.set_sequence(sequence);
  sample.set_finger(finger);
  *sample.mutable_sensed_at() = palpate::Now();
  for (int i = 0; i < electrodes; ++i) sample.add_electrodes(3000.0F + static_cast<float>(i));
  sample.add_pressure(2000);
  sample.add_pressure(1800);
  return sample;
}

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: feed_tactile HOST:PORT\n");
    return 2;
  }
  const palpate::Slave slave(argv[1]);
  const auto scene = slave.Scene();
  const auto& fingers = scene.fingertips();
  if (fingers.empty()) {
    std::fprintf(stderr, "%s has no fingertips\n", scene.name().c_str());
    return 1;
  }
  const auto samples = 50 * static_cast<std::uint64_t>(fingers.size());
  std::uint64_t sent = 0;
  const auto accepted = slave.FeedFingertips([&]() -> std::optional<palpate::v1::TactileSample> {
    if (sent == samples) return std::nullopt;
    const auto finger = static_cast<int>(sent % static_cast<std::uint64_t>(fingers.size()));
    if (finger == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return Rest(++sent, fingers[finger].name(), 19);
  });
  std::string names;
  for (const auto& finger : fingers) names += (names.empty() ? "" : ", ") + finger.name();
  std::printf("%s: %lu samples of %s accepted\n", scene.name().c_str(), accepted, names.c_str());
  try {
    bool is_first = true;
    (void)slave.FeedFingertips([&]() -> std::optional<palpate::v1::TactileSample> {
      if (!std::exchange(is_first, false)) return std::nullopt;
      return Rest(1, fingers[0].name(), 18);
    });
  } catch (const palpate::Error& error) {
    std::printf("18 electrodes: %s\n", error.what());
    return accepted == samples && error.code() == grpc::INVALID_ARGUMENT ? 0 : 1;
  }
  return 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
