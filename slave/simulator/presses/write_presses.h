// `palpate-simulator presses`: contacts of the simulated fingertip as CSV files, from which
// `python3 -m palpate.train` trains a force network.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>

namespace palpate {

struct PressesOptions {
  std::filesystem::path out;  // folder, created if missing
  std::int64_t seed = 1;      // >= 0
  int presses = 1500;         // >= 1
};

// Writes DIR/start00001.csv and so on, one file per start of the fingertip, with the columns t [s],
// E1 to E19, pac0, pdc [counts] and fx, fy, fz, the force of the fingertip on the object in frame F
// [N]. 0: all written; 1: stopped. Throws std::invalid_argument for unusable options and
// std::runtime_error naming a file that cannot be written.
int WritePresses(const PressesOptions& options, const std::stop_token& stop);

}  // namespace palpate
