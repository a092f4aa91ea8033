// The position of a sample in a run and the true state that its image shows. Alterations take it as
// their input.
#pragma once

#include <cstddef>

#include <Eigen/Core>

namespace palpate::robustness {

// A press in numbers of samples: rest, approach, hold, retreat, rest.
struct Script {
  std::size_t way = 0;    // first sample of the approach; samples before it give the rest state
  std::size_t touch = 0;  // the first in contact
  std::size_t hold = 0;   // the first at the full depth
  std::size_t back = 0;   // first sample of the retreat
  std::size_t count = 0;
};

struct Moment {
  Script script;
  std::size_t index = 0;  // of the sample in the run, from 0
  int side = 0;           // of a pair: 0 left, 1 right

  // Returns the completed fraction of the run, 0 to 1.
  [[nodiscard]] double share() const {
    return script.count > 1 ? static_cast<double>(index) / static_cast<double>(script.count - 1)
                            : 0;
  }
};

// A moment, with the places of the parts in its image [px].
struct View : Moment {
  Eigen::Vector2d tip_I{0, 0};      // the tool's tip; for pairs: the pressed point
  Eigen::Vector2d pressed_I{0, 0};  // position of the tip at full depth
  Eigen::Vector2d shaft_I{0, -1};   // unit, from the tip along the tool's shaft
  double width = 0;                 // of the tool [px]
};

// Start of an alteration.
enum class When { kAlways, kAtRest, kPressed };
inline bool IsSo(When when, const Moment& moment) {
  switch (when) {
    case When::kAlways:
      return true;
    case When::kAtRest:
      return moment.index >= moment.script.way;
    case When::kPressed:
      break;
  }
  return moment.index >= (moment.script.hold + moment.script.back) / 2;
}

}  // namespace palpate::robustness
