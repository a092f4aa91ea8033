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

long PixelsOf(const CodedPicture& picture) {
  return long{picture.size().width} * picture.size().height;
}

std::unique_ptr<CodedPicture> Open(const std::string& bytes) {
  const Bytes file(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  auto picture = NamingImage([&] {
    auto png = OpenPng(file);
    return png ? std::move(png) : OpenJpeg(file);
  });
  if (!picture) throw std::invalid_argument("image: expected a PNG or JPEG file");
  if (PixelsOf(*picture) > kMostImagePixels) {
    throw std::invalid_argument(fmt::format("image of {} x {} px: expected at most {} megapixels",
                                            picture->size().width, picture->size().height,
                                            kMostImagePixels / 1'000'000));
  }
  return picture;
}

}  // namespace

void RequireBounded(std::span<const std::string> images) {
  long pixels = 0;
  for (const std::string& image : images) pixels += PixelsOf(*Open(image));
  if (pixels <= kMostRequestPixels) return;
  throw std::invalid_argument(
      fmt::format("{} images of {} megapixels: expected at most {} megapixels together",
                  images.size(), pixels / 1'000'000, kMostRequestPixels / 1'000'000));
}

cv::Mat DecodeBounded(const std::string& image) {
  const auto picture = Open(image);
  return NamingImage([&] { return picture->Decode(); });
}

}  // namespace palpate
