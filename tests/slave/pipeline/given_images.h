// Images that a test hands over.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include <opencv2/core/mat.hpp>

#include "slave/capture/frame_source.h"

namespace palpate {

class GivenImages final : public StereoSource {
 public:
  explicit GivenImages(std::shared_ptr<std::deque<cv::Mat>> images) : images_(std::move(images)) {}
  std::optional<StereoPair> Next(const std::stop_token&) override {
    StereoPair pair;
    pair.sequence = ++sequence_;
    pair.left = images_->front();
    images_->pop_front();
    return pair;
  }
  [[nodiscard]] std::string description() const override { return "given"; }

 private:
  std::shared_ptr<std::deque<cv::Mat>> images_;
  std::uint64_t sequence_ = 0;
};

}  // namespace palpate
