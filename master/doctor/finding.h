// A finding of the doctor: verdict, measured value and advice.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

enum class Verdict : std::uint8_t {
  kGood,
  kNote,  // works, but could be better
  kBad,   // degrades the force or prevents operation
};

struct Finding {
  Verdict verdict = Verdict::kGood;
  std::string what;      // "timer"
  std::string measured;  // text with numbers and units
  std::string advice;    // change to make; empty: none
};
using Findings = std::vector<Finding>;

}  // namespace palpate
