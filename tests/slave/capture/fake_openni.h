// A depth camera that exists only in memory, behind the functions of libOpenNI2.so.0, whose place
// it takes in the test that links it.
#pragma once

#include <cstdint>
#include <vector>

namespace palpate {

struct FakeOpenNi {
  int cameras = 1;            // plugged in
  bool has_depth = true;      // a camera with a sensor of depth
  bool can_unmirror = true;   // some show a mirror's view whatever they are stated
  double unit = 1e-3;         // of a count [m]; neither 1 mm nor 0.1 mm: it tells no depth
  bool shows = true;          // pictures come; else the wait for one times out
  int width = 4, height = 2;  // [px]
  std::vector<std::uint16_t> counts{1, 2, 3, 4, 5, 6, 7, 8};  // as seen, not mirrored
};

// State of the whole process. Not thread-safe.
FakeOpenNi& TheFakeOpenNi();

}  // namespace palpate
