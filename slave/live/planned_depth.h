// Compares the indentation of each contact with operator.press.depth, for which the model was
// chosen.
#pragma once

#include <string>

#include "shared/state/slave_state.h"

namespace palpate {

// Used by one thread.
class PlannedDepth {
 public:
  // `planned`: operator.press.depth [m], > 0.
  explicit PlannedDepth(double planned) : planned_(planned), reported_(kDeeper * planned) {}

  // Call it for each sample. Returns the text of an alarm when a contact ends that was more than a
  // tenth deeper than planned and deeper than any reported before; else empty.
  [[nodiscard]] std::string Update(const ContactEstimate& estimate, bool touches);

 private:
  static constexpr double kDeeper = 1.1;  // depth that is reported, relative to the planned one [-]

  const double planned_;  // [m]
  double reported_;       // only deeper contacts are reported [m]
  double deepest_ = 0;    // largest depth of this contact [m]
};

}  // namespace palpate
