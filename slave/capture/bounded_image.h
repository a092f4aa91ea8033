// Images of a client, whose size is bounded before they are decoded.
#pragma once

#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace palpate {

// Pixels of one image, and of several of one request together.
inline constexpr long kMaxImagePixels = 25'000'000, kMaxRequestPixels = 250'000'000;

// Throws std::invalid_argument: an image is no PNG or JPEG, is damaged at its beginning or too
// large, or all are too large together.
void RequireBounded(std::span<const std::string> images);
// Decodes a PNG or JPEG of at most kMaxImagePixels. Throws std::invalid_argument: it cannot be
// used.
cv::Mat DecodeBounded(const std::string& image);

}  // namespace palpate
