// Decodes images in a separate thread, a few ahead of the reader, and assigns timestamps.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "slave/capture/frame_source.h"

namespace palpate {

class DecodeAhead final : public FrameSource {
 public:
  // The next image; an empty one: the source has ended. Throws on errors of the source.
  using Decode = std::function<cv::Mat()>;

  struct Options {
    std::string description;
    double rate = 60;  // timestamps of recorded images are 1 / rate apart [Hz], > 0,
    // or these multiples of it from the first, one per image; empty: no gaps
    std::vector<std::uint64_t> instants = {};
    bool paced = false;  // recorded images arrive at their timestamps
    bool live = false;   // timestamps are the time of decoding, and a slow reader loses old images
  };

  DecodeAhead(Decode decode, Options options);

  std::optional<Frame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override { return options_.description; }

 private:
  // Number of images: at 60 Hz a disk may be late by 67 ms.
  static constexpr std::size_t kRecordedAhead = 4;
  static constexpr std::size_t kLiveAhead = 1;  // a live image is useful only while it is new

  void Run(const std::stop_token& stop);
  bool Push(Frame frame, const std::stop_token& stop);
  void WaitForStamp(const Frame& frame, const std::stop_token& stop);
  [[nodiscard]] Time StampOf(std::uint64_t sequence) const;

  Decode decode_;
  Options options_;
  Time start_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Frame> ready_;     // guarded by mutex_
  bool ended_ = false;          // guarded by mutex_
  std::exception_ptr failure_;  // guarded by mutex_
  std::jthread thread_;         // last member: it stops and joins before the others are destroyed
};

}  // namespace palpate
