// What the doctor found: how it is, what was measured, what to change.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

enum class Verdict : std::uint8_t {
  kGood,
  kNote,  // works, and could be better
  kBad,   // will be felt, or keeps it from working
};

struct Finding {
  Verdict verdict = Verdict::kGood;
  std::string what;      // "timer"
  std::string measured;  // in words, with numbers and units
  std::string advice;    // what to change; empty: nothing
};
using Findings = std::vector<Finding>;

}  // namespace palpate
