// How recordings are named on the command line.
#pragma once

#include <filesystem>
#include <limits>
#include <string>

namespace palpate {

// TACTILE.csv[+WRENCH.csv][@FROM:TO]
struct DataArgument {
  std::string text;  // as it was given
  std::filesystem::path tactile;
  std::filesystem::path wrench;  // empty: the force stands in the tactile file
  double from = -std::numeric_limits<double>::infinity();  // [s], of the tactile file's clock
  double to = std::numeric_limits<double>::infinity();
};

// FROM or TO may be left out. A file whose own name contains + or @ is found as it is. Throws
// std::invalid_argument: a slice that is none, an empty name.
DataArgument ParseDataArgument(const std::string& text);

}  // namespace palpate
