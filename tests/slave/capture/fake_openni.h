// A depth camera of 4 x 2 px that counts from 1 to 8 and exists only in memory, behind the
// functions of libOpenNI2.so.0, whose place it takes in the test that links it.
#pragma once

namespace palpate {

struct FakeOpenNi {
  int cameras = 1;           // plugged in
  bool has_depth = true;     // a camera with a sensor of depth
  bool can_unmirror = true;  // some show a mirror's view whatever they are stated
  double unit = 1e-3;        // of a count [m]; neither 1 mm nor 0.1 mm: it tells no depth
};

// State of the whole process. Not thread-safe.
FakeOpenNi& TheFakeOpenNi();

}  // namespace palpate
