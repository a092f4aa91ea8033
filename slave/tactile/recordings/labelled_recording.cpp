#include "slave/tactile/recordings/labelled_recording.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <stdexcept>
#include <utility>

namespace palpate {
namespace {

constexpr float kContactShare = 0.05F;  // of the largest force
constexpr double kPause = 0.5;          // [s]
constexpr double kTouch = 0.1;          // shorter contact is a spike of the force sensor [s]

struct Contact {
  std::size_t begin, end;
};

std::vector<Contact> ContactsOf(const LabelledRecording& recording, float threshold) {
  std::vector<Contact> contacts;
  for (std::size_t i = recording.begin; i < recording.end; ++i) {
    if (!(recording.force[i].norm() > threshold)) continue;
    if (!contacts.empty() && recording.t[i] - recording.t[contacts.back().end - 1] < kPause) {
      contacts.back().end = i + 1;
    } else {
      contacts.push_back({i, i + 1});
    }
  }
  std::erase_if(contacts, [&](const Contact& c) {
    return recording.t[c.end - 1] - recording.t[c.begin] < kTouch;
  });
  return contacts;
}

constexpr double kSetAside = 0.2;
constexpr std::size_t kEnoughRecordings = 5;
constexpr std::size_t kShortestPart = 60;  // samples: windows of 50 and a few more

// What moves as one from part to part.
using Unit = std::vector<Stretch>;

std::vector<Unit> UnitsOf(const std::vector<Stretch>& presses, bool by_recording) {
  std::vector<Unit> units;
  for (const Stretch& press : presses) {
    if (by_recording && !units.empty() && units.back().front().recording == press.recording) {
      units.back().push_back(press);
    } else {
      units.push_back({press});
    }
  }
  return units;
}

// Not std::shuffle, which differs from library to library.
void Shuffle(std::vector<Unit>* units, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = units->size(); i > 1; --i)
    std::swap((*units)[i - 1], (*units)[random() % i]);
}

// Takes a fifth of the units, at least one, off the end.
std::vector<Stretch> TakeFifth(std::vector<Unit>* units) {
  const auto wanted = static_cast<std::size_t>(
      std::max(1L, std::lround(kSetAside * static_cast<double>(units->size()))));
  std::vector<Stretch> taken;
  for (std::size_t i = 0; i < wanted; ++i) {
    std::ranges::copy(units->back(), std::back_inserter(taken));
    units->pop_back();
  }
  return taken;
}

// Where a stretch of `length` is cut: two of its tenths are taken, or the fifth in its middle where
// tenths were too short for windows, or nothing.
std::vector<std::pair<std::size_t, std::size_t>> CutsOf(std::size_t length) {
  const std::size_t tenth = length / 10;
  if (tenth >= kShortestPart) return {{3 * tenth, 4 * tenth}, {6 * tenth, 7 * tenth}};
  if (2 * tenth >= kShortestPart) return {{4 * tenth, 6 * tenth}};
  return {};
}

// Parts of every stretch; what is left no longer looks back into them.
std::vector<Stretch> TakeParts(std::vector<Stretch>* stretches) {
  std::vector<Stretch> taken, left;
  for (const Stretch& s : *stretches) {
    Stretch rest = s;
    for (const auto& [from, to] : CutsOf(s.end - s.begin)) {
      rest.end = s.begin + from;
      left.push_back(rest);
      taken.push_back({s.recording, s.begin + from, s.begin + to, s.begin + from});
      rest.begin = rest.look_back = s.begin + to;
    }
    rest.end = s.end;
    left.push_back(rest);
  }
  *stretches = left;
  return taken;
}

std::string Count(std::size_t n, bool recordings) {
  const char* many = recordings ? " recordings" : " contacts";
  const char* one = recordings ? " recording" : " contact";
  return std::to_string(n) + (n == 1 ? one : many);
}

}  // namespace

std::vector<Window> WindowsOf(std::span<const Stretch> stretches, int steps) {
  const auto before = static_cast<std::size_t>(steps - 1);
  std::vector<Window> windows;
  for (const Stretch& stretch : stretches) {
    for (std::size_t i = std::max(stretch.begin, stretch.look_back + before); i < stretch.end;
         ++i) {
      windows.push_back({stretch.recording, i});
    }
  }
  return windows;
}

std::vector<Stretch> FindPresses(std::span<const LabelledRecording> recordings) {
  float largest = 0;
  for (const LabelledRecording& r : recordings) {
    for (std::size_t i = r.begin; i < r.end; ++i) largest = std::max(largest, r.force[i].norm());
  }
  std::vector<Stretch> presses;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const LabelledRecording& r = recordings[k];
    const std::vector<Contact> contacts = ContactsOf(r, kContactShare * largest);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      Stretch press{k, r.begin, r.end, r.begin};
      if (i > 0) press.begin = press.look_back = presses.back().end;
      if (i + 1 < contacts.size()) press.end = (contacts[i].end + contacts[i + 1].begin) / 2;
      presses.push_back(press);
    }
  }
  return presses;
}

Split SplitContacts(std::span<const LabelledRecording> recordings, bool test_is_apart,
                    std::uint64_t seed) {
  const std::vector<Stretch> presses = FindPresses(recordings);
  if (presses.empty()) throw std::invalid_argument("the recordings contain no contact");
  const bool by_recording = UnitsOf(presses, true).size() >= kEnoughRecordings;
  std::vector<Unit> units = UnitsOf(presses, by_recording);
  Shuffle(&units, seed);

  Split split;
  std::string test = "a separate set", validation;
  const bool test_by_unit = !test_is_apart && units.size() > 1;
  if (test_by_unit) {
    const std::size_t before = units.size();
    split.test = TakeFifth(&units);
    test = Count(before - units.size(), by_recording);
  }
  const bool validate_by_unit = units.size() >= 3;
  if (validate_by_unit) {
    const std::size_t before = units.size();
    split.validation = TakeFifth(&units);
    validation = Count(before - units.size(), by_recording);
  }
  const std::size_t left = units.size();
  for (const Unit& unit : units) std::ranges::copy(unit, std::back_inserter(split.train));
  if (!test_by_unit && !test_is_apart) {
    split.test = TakeParts(&split.train);
    test = "parts of the same contact (there is only one: the errors are too small)";
  }
  if (!validate_by_unit) {
    split.validation = TakeParts(&split.train);
    validation = "parts of the same";
  }
  split.how = "by whole " + std::string(by_recording ? "recordings" : "contacts") + ": train " +
              Count(left, by_recording) + ", validation " + validation + ", test " + test;
  return split;
}

}  // namespace palpate
