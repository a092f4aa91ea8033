// Receives the newest image of the slave, on a separate channel and thread. While it exists, the
// slave encodes images for it, so make one only if they are shown.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "master/link/slave_link.h"

namespace palpate {

// A received image.
struct RemotePicture {
  std::uint64_t number = 0;   // rises by one per image
  Time sensed_at{};           // slave's clock
  int width = 0, height = 0;  // [px]
  std::string jpeg;
};

class VideoWatch {
 public:
  struct Options {
    double rate = 15;  // largest rate [Hz], 1 to 120
    int quality = 75;  // of the JPEG, 10 to 100
  };
  // Requests images with the slave's overlays. Opens the stream and keeps it open, reconnecting
  // with back-off. Throws std::invalid_argument for an invalid target, or one beyond loopback
  // without `insecure`.
  VideoWatch(const SlaveLink::Options& link, const Options& options);
  ~VideoWatch();

  // Null: none received yet. Thread-safe.
  [[nodiscard]] std::shared_ptr<const RemotePicture> newest() const;
  // Why none is received; empty: no problem. Thread-safe.
  [[nodiscard]] std::string trouble() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
