// A finding of the doctor: grade, measured value and advice.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

enum class Grade : std::uint8_t {
  kGood,
  kNote,  // works, but could be better
  kBad,   // degrades the force or prevents operation
};

struct Finding {
  Grade grade = Grade::kGood;
  std::string what;      // "timer"
  std::string measured;  // text with numbers and units
  std::string advice;    // change to make; empty: none
};
using Findings = std::vector<Finding>;

}  // namespace palpate
