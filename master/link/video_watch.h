// Watches the slave's pictures beside the force: a channel and a thread of its own, the newest
// picture only. While it lives the slave encodes pictures for it: make one only where somebody
// looks.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "master/link/slave_link.h"

namespace palpate {

// A picture as it came.
struct RemotePicture {
  std::uint64_t number = 0;   // rises by one with each that came
  Time sensed_at{};           // slave's clock
  int width = 0, height = 0;  // [px]
  std::string jpeg;
};

class VideoWatch {
 public:
  struct Options {
    double rate = 15;  // at most so many a second [Hz], 1 to 120
    int quality = 75;  // of the JPEG, 10 to 100
  };
  // Pictures with the slave's overlays. Opens the stream and keeps it open, reconnecting with
  // back-off. Throws std::invalid_argument: target not understood, or not loopback without
  // `insecure`.
  VideoWatch(const SlaveLink::Options& link, const Options& options);
  ~VideoWatch();

  // Null: none came yet. Thread-safe.
  [[nodiscard]] std::shared_ptr<const RemotePicture> newest() const;
  // Why none comes at the moment; empty: they do. Thread-safe.
  [[nodiscard]] std::string trouble() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
