// Arranges images of cameras as the sensing needs them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "slave/capture/frame_source.h"

namespace palpate {

enum class PairLayout : std::uint8_t { kOneCamera, kTwoCameras, kSideBySide, kDepth };

// The images of one or two cameras: a pair in grey, depth and single images as they are. Throws
// std::runtime_error that begins with `name`: a type that pairs or depth do not accept, two sizes.
StereoPair Arranged(StereoPair images, PairLayout layout, const std::string& name);

// `1 channel of 8 bit`
std::string TypeInWords(int type);

// Returns the left images of `source`, each processed by `filter` if there is one.
std::unique_ptr<FrameSource> LeftImages(std::unique_ptr<StereoSource> source,
                                        ImageFilter filter = {});

}  // namespace palpate
