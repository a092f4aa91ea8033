#include "slave/commands/serve/scene_mistakes.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kMaxPartLength = 600;  // [bytes]
constexpr std::size_t kMaxLines = 20;

bool IsInKey(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

// Returns whether a word is a key such as `sense.tip.anchor`, or `camera.rate` in messages that do
// not name the section.
bool IsKey(std::string_view word) {
  constexpr std::array<std::string_view, 7> kBegins{"object.", "sense.",       "tool.",    "model.",
                                                    "camera.", "manipulator.", "operator."};
  return std::ranges::any_of(kBegins, [&](std::string_view begin) {
    return word.starts_with(begin) && word.size() > begin.size();
  });
}

// The first key in `text`; empty: there is none.
std::string_view KeyIn(std::string_view text) {
  for (std::size_t begin = 0; begin < text.size();) {
    const auto rest = text.substr(begin);
    const auto end = std::ranges::find_if_not(rest, IsInKey);
    std::string_view word = rest.substr(0, static_cast<std::size_t>(end - rest.begin()));
    begin += word.size() + 1;
    while (word.ends_with('.')) word.remove_suffix(1);  // the full stop of the sentence
    if (IsKey(word)) return word;
  }
  return {};
}

// The end of a value: a list or a map ends with its bracket, others before a colon.
std::size_t EndOfValue(std::string_view text) {
  const bool is_bracketed = text.starts_with('[') || text.starts_with('{');
  const std::size_t bracket = is_bracketed ? text.find_last_of("]}") : std::string_view::npos;
  const std::size_t from = bracket == std::string_view::npos ? 0 : bracket;
  return std::min(text.find(": ", from), text.size());
}

}  // namespace

std::vector<SceneMistake> MistakesOf(const SceneError& error) {
  std::vector<SceneMistake> mistakes = error.mistakes();
  for (SceneMistake& mistake : mistakes) {
    if (mistake.message.empty()) mistake.message = "not accepted";
  }
  return mistakes;
}

SceneMistake MistakeIn(const std::string& message) {
  constexpr std::string_view kExpected = ": expected ", kIs = " = ", kColon = ": ";
  std::string_view text = message;
  SceneMistake mistake;
  if (const std::size_t at = text.rfind(kExpected); at != std::string_view::npos) {
    mistake.expected = Shown(text.substr(at + kExpected.size()), kMaxPartLength);
    text = text.substr(0, at);
  }
  const std::string_view key = KeyIn(text);
  mistake.key = Shown(key);
  if (!key.empty() && text.starts_with(key)) {
    std::string_view rest = text.substr(key.size());
    if (rest.starts_with(kIs)) {
      const std::size_t end = EndOfValue(rest.substr(kIs.size()));
      mistake.value = Shown(rest.substr(kIs.size(), end));
      rest = rest.substr(kIs.size() + end);
      text = rest.empty() ? "not accepted" : rest;
    } else if (rest.starts_with(kColon)) {
      text = rest;
    }
    if (text.starts_with(kColon)) text = text.substr(kColon.size());
  }
  mistake.message = Shown(text, kMaxPartLength);
  if (mistake.key.starts_with("camera.")) mistake.key.insert(0, "sense.");
  return mistake;
}

std::string InWords(const std::vector<SceneMistake>& mistakes) {
  std::string words;
  for (std::size_t i = 0; i < std::min(mistakes.size(), kMaxLines); ++i) {
    const SceneMistake& mistake = mistakes[i];
    words += words.empty() ? "" : "\n";
    if (mistake.line > 0) words += fmt::format("line {}: ", mistake.line);
    words += mistake.key;
    if (!mistake.value.empty()) words += " = " + mistake.value;
    if (!mistake.message.empty()) words += (mistake.key.empty() ? "" : ": ") + mistake.message;
    if (!mistake.expected.empty()) words += ": expected " + mistake.expected;
  }
  if (mistakes.size() > kMaxLines) {
    words += fmt::format("\nand {} more mistakes", mistakes.size() - kMaxLines);
  }
  return words;
}

}  // namespace palpate
