// A scene's text.
#pragma once

#include <string>

namespace palpate {

// Returns a scene with one entry per line, so that tests can replace or add a line with a known
// number.
inline std::string SmallScene() {
  return "name: small\n"                                                              // 1
         "object:\n"                                                                  // 2
         "  geometry: {rectangle: {width: 80 mm, height: 40 mm, thickness: 9 mm}}\n"  // 3
         "  material: {young_modulus: 127 kPa, poisson_ratio: 0.49}\n"                // 4
         "  fixed: {side: bottom}\n"                                                  // 5
         "model: {kind: bem2d}\n"                                                     // 6
         "tool: {shape: flat, width: 5.87 mm}\n"                                      // 7
         "sense:\n"                                                                   // 8
         "  camera: {source: simulated, pixel: 0.35 mm}\n"                            // 9
         "  tip: {track: template}\n"                                                 // 10
         "  contour: {track: snake}\n";                                               // 11
}

// SmallScene with line `line` (from 1) replaced.
inline std::string SmallSceneWith(int line, const std::string& replacement) {
  std::string text = SmallScene();
  std::size_t begin = 0;
  for (int i = 1; i < line; ++i) begin = text.find('\n', begin) + 1;
  return text.replace(begin, text.find('\n', begin) - begin, replacement);
}

}  // namespace palpate
