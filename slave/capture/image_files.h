// Image files: listing by pattern, reading and writing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

// Returns the files that match `pattern`, sorted by time:
//   frames/%04d.png  a printf pattern with one %d: from 0, else from 1, else from the smallest
//                    number there is, gaps left out
//   frames/*.jpg     a glob (* and ? in the file name), sorted naturally: img2 before img10
//   frames           a directory: every image in it, sorted naturally
//   embryo.jpg       one image
// A relative pattern is relative to `base`. Throws std::runtime_error naming the pattern: nothing
// matches, no such directory, a malformed printf pattern.
std::vector<std::filesystem::path> ListImages(const std::string& pattern,
                                              const std::filesystem::path& base);

// Digits compare as numbers, everything else as characters.
bool NaturallyLess(const std::string& a, const std::string& b);

// Returns when each of `files`, listed in the order of time, was taken: in periods since the first
// file, from the last number in each name. The smallest rise of the numbers is one period; a larger
// rise is a gap. The result is 0, 1, 2, ... if names have no such numbers, or if more images would
// be missing than exist.
std::vector<std::uint64_t> InstantsOf(const std::vector<std::filesystem::path>& files);
// Returns a text for the number of missing images, to be put after a count: `, 3 missing`; empty:
// none.
std::string MissingInWords(const std::vector<std::uint64_t>& instants);

// The last number in the file's name, without leading zeros: 7 of left_007.png; empty: none.
std::string LastNumber(const std::filesystem::path& file);

// Gets an image's width and height before its pixels need memory; throws if they do not fit.
using AcceptSize = std::function<void(const cv::Size&)>;

// Reads one image unchanged, 8 or 16 bit, without alpha. PNG and JPEG are decoded here, other
// formats by the module palpate-cameras. Throws std::runtime_error naming the file and its `number`
// (from 1): missing, not an image, truncated, damaged, more than kMaxPixels; exceptions of
// `accept`.
cv::Mat ReadImage(const std::filesystem::path& file, std::size_t number,
                  const AcceptSize& accept = {});

}  // namespace palpate
