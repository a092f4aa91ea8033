#include "slave/tactile/recordings/labelled_recording.h"

#include <algorithm>

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

}  // namespace palpate
