// The trial that a tick belongs to. Small and without pointers, so that it travels with each tick.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace palpate {

struct TrialLabel {
  static constexpr std::size_t kLongest = 31;  // [characters]

  std::uint32_t number = 0;               // in the order of the run, from 1; 0: no trials
  std::array<char, kLongest + 1> text{};  // of its condition, ends with a zero

  [[nodiscard]] std::string_view view() const { return text.data(); }
};

// `text` is cut to TrialLabel::kLongest.
inline TrialLabel MakeTrialLabel(std::uint32_t number, std::string_view text) {
  TrialLabel label;
  label.number = number;
  text.substr(0, TrialLabel::kLongest).copy(label.text.data(), TrialLabel::kLongest);
  return label;
}

}  // namespace palpate
