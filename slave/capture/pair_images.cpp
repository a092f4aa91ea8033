#include "slave/capture/pair_images.h"

#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

cv::Mat Grey(const cv::Mat& image, const std::string& name) {
  if (image.depth() != CV_8U) {
    throw std::runtime_error(name + ": 16 bit: for a pair of cameras, expected 8 bit");
  }
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

class LeftImagesOf final : public FrameSource {
 public:
  LeftImagesOf(std::unique_ptr<StereoSource> source, ImageFilter filter)
      : source_(std::move(source)), filter_(std::move(filter)) {}
  std::optional<Frame> Next(const std::stop_token& stop) override {
    const auto images = source_->Next(stop);
    if (!images) return std::nullopt;
    return Frame{filter_ ? filter_(images->left) : images->left, images->sequence,
                 images->sensed_at};
  }
  [[nodiscard]] std::string description() const override { return source_->description(); }
  [[nodiscard]] std::optional<CameraHealth> health() const override { return source_->health(); }

 private:
  std::unique_ptr<StereoSource> source_;
  ImageFilter filter_;
};

}  // namespace

StereoPair Arranged(StereoPair images, PairLayout layout, const std::string& name) {
  const auto refuse = [&](const std::string& why) { throw std::runtime_error(name + ": " + why); };
  if (layout == PairLayout::kOneCamera) return images;
  if (layout == PairLayout::kDepth) {
    if (images.left.type() == CV_16UC1) return images;
    refuse(TypeInWords(images.left.type()) + ": for depth, expected one channel of 16 bit");
  }
  images.left = Grey(images.left, name);
  if (layout == PairLayout::kSideBySide) {
    const cv::Mat both = images.left;
    if (both.cols % 2 != 0) {
      refuse(fmt::format("{} px wide: side by side, expected an even number", both.cols));
    }
    images.left = both.colRange(0, both.cols / 2).clone();
    images.right = both.colRange(both.cols / 2, both.cols).clone();
    return images;
  }
  images.right = Grey(images.right, name);
  if (images.left.size() != images.right.size()) {
    refuse(fmt::format("{} x {} and {} x {} px: expected images of one size", images.left.cols,
                       images.left.rows, images.right.cols, images.right.rows));
  }
  return images;
}

std::string TypeInWords(int type) {
  return fmt::format("{} channel{} of {} bit", CV_MAT_CN(type), CV_MAT_CN(type) == 1 ? "" : "s",
                     8 * CV_ELEM_SIZE1(type));
}

std::unique_ptr<FrameSource> LeftImages(std::unique_ptr<StereoSource> source, ImageFilter filter) {
  return std::make_unique<LeftImagesOf>(std::move(source), std::move(filter));
}

}  // namespace palpate
