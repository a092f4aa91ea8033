// Operates a slave: operate HOST:PORT [TLS_FOLDER]. Moves the tool 9 mm down along y, in the
// silicone block 6 mm of air and 3 mm of indentation, holds and retreats. Prints the peak force.
// Exit code 0: the force opposed the motion; 1: otherwise.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>

#include <palpate/client.h>

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: operate HOST:PORT [TLS_FOLDER]\n");
    return 2;
  }
  constexpr double kDown = 9e-3, kSpeed = 6e-3;  // [m], [m/s]
  const palpate::Slave slave(argv[1], argc > 2 ? argv[2] : "");
  const auto tool = slave.Operate("operate.cpp");
  tool->MoveBy({0, -kDown, 0}, kSpeed);
  double peak = 0;
  const auto states = tool->Hold(std::chrono::milliseconds(500));
  for (const palpate::State& state : states) {
    if (state.valid()) peak = std::max(peak, state.force()[1]);
  }
  tool->MoveBy({0, kDown, 0}, kSpeed);
  std::printf("%s: %zu states, peak force %.4f N\n", slave.Scene().name().c_str(), states.size(),
              peak);
  return peak > 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
