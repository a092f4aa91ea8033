#include "slave/capture/bounded_image.h"

#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

template <class Work>
auto NamingImage(const Work& work) {
  try {
    return work();
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(std::string("the image ") + error.what());
  }
}

long PixelsOf(const CodedImage& image) {
  return long{image.size().width} * image.size().height;
}

std::unique_ptr<CodedImage> Open(const std::string& bytes) {
  const Bytes file(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  auto image = NamingImage([&] {
    auto png = OpenPng(file);
    return png ? std::move(png) : OpenJpeg(file);
  });
  if (!image) throw std::invalid_argument("image: expected a PNG or JPEG file");
  if (PixelsOf(*image) > kMaxImagePixels) {
    throw std::invalid_argument(fmt::format("image of {} x {} px: expected at most {} megapixels",
                                            image->size().width, image->size().height,
                                            kMaxImagePixels / 1'000'000));
  }
  return image;
}

}  // namespace

void RequireBounded(std::span<const std::string> images) {
  long pixels = 0;
  for (const std::string& image : images) pixels += PixelsOf(*Open(image));
  if (pixels <= kMaxRequestPixels) return;
  throw std::invalid_argument(
      fmt::format("{} images of {} megapixels: expected at most {} megapixels together",
                  images.size(), pixels / 1'000'000, kMaxRequestPixels / 1'000'000));
}

cv::Mat DecodeBounded(const std::string& image) {
  const auto coded = Open(image);
  return NamingImage([&] { return coded->Decode(); });
}

}  // namespace palpate
