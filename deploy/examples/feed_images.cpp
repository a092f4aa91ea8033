// Sends thirty grey images to a slave: feed_images HOST:PORT [WIDTH HEIGHT], default 64 48. Half
// an image follows, which must be rejected with an explanation. The scene needs a camera with
// `source: stream`. Prints the number of accepted images. Exit code 0: all.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <palpate/client.h>

// An image whose brightness rises from pixel to pixel; with `missing` pixels left out.
palpate::v1::ImageSample Grey(std::uint32_t sequence, std::uint32_t width, std::uint32_t height,
                              std::uint32_t missing = 0) {
  palpate::v1::ImageSample sample;
  sample.set_sequence(sequence);
  *sample.mutable_sensed_at() = palpate::Now();
  auto& image = *sample.mutable_image();
  image.set_encoding(palpate::v1::Image::ENCODING_GREY8);
  image.set_width(width);
  image.set_height(height);
  for (std::uint32_t i = missing; i < width * height; ++i) {
    image.mutable_data()->push_back(static_cast<char>(sequence + i));
  }
  return sample;
}

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: feed_images HOST:PORT [WIDTH HEIGHT]\n");
    return 2;
  }
  constexpr std::uint32_t kImages = 30;
  const auto width = static_cast<std::uint32_t>(argc > 3 ? std::atoi(argv[2]) : 64);
  const auto height = static_cast<std::uint32_t>(argc > 3 ? std::atoi(argv[3]) : 48);
  const palpate::Slave slave(argv[1]);
  std::uint32_t sent = 0;
  const auto reply = slave.FeedImages([&]() -> std::optional<palpate::v1::ImageSample> {
    if (sent == kImages) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
    return Grey(++sent, width, height);
  });
  std::printf("%lu of %u images accepted\n", reply.samples(), kImages);
  try {
    bool is_first = true;
    (void)slave.FeedImages([&]() -> std::optional<palpate::v1::ImageSample> {
      if (!std::exchange(is_first, false)) return std::nullopt;
      return Grey(1, width, height, width * height / 2);
    });
  } catch (const palpate::Error& error) {
    std::printf("half an image: %s\n", error.what());
    return reply.samples() == kImages && error.code() == grpc::INVALID_ARGUMENT ? 0 : 1;
  }
  return 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
