// Decodes pictures in a thread of its own, a few ahead of the reader, and gives them their stamps.
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
  // The next picture; an empty one: the source has ended. Throws where it breaks.
  using Decode = std::function<cv::Mat()>;

  struct Options {
    std::string description;
    double rate = 60;  // stamps of recorded pictures lie 1 / rate apart [Hz], > 0,
    // or so many times that from the first, one per picture; empty: there are no gaps.
    std::vector<std::uint64_t> instants = {};
    bool paced = false;  // recorded pictures come when their stamps say
    bool live = false;   // stamps are the clock's at decoding, and a late reader loses old pictures
  };

  DecodeAhead(Decode decode, Options options);

  std::optional<Frame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override { return options_.description; }

 private:
  // Pictures: at 60 Hz a disk may be late by 67 ms.
  static constexpr std::size_t kRecordedAhead = 4;
  static constexpr std::size_t kLiveAhead = 1;  // a live picture is only good while it is new

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
  std::jthread thread_;         // last: it stops and joins before the rest goes
};

}  // namespace palpate
