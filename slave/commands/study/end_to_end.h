// Error budget of the rendered force: vision, contact, model, rendering and link, with a simulator
// that knows the truth.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/scene/scene.h"

namespace palpate {

// Contribution of one stage to the error, beyond the stages before it.
struct BudgetPart {
  std::string name;            // vision, contact, model, rendering, link; material
  double rms = 0;              // over the ticks in contact, mean over the presses [N]
  bool is_stated = false;      // from the scene's tolerance: the simulator knows it exactly
  std::string lowers;          // measure that reduces it, one clause
  double least = 0, most = 0;  // of the presses [N]
};

struct EndToEndBudget {
  std::string scene;
  std::size_t presses = 0;
  double peak = 0;   // the largest true force, mean over the presses [N]
  double total = 0;  // error of the rendered force, rms over the ticks in contact [N]
  double delay = 0;  // of the link [s]
  std::vector<BudgetPart> parts;

  [[nodiscard]] const BudgetPart& largest() const;
};

// Simulates the scene's contact, at its own place and up to a fifth of the object's size to either
// side of it, by the simulated operator and the rendering at 1 kHz, `delay` [s]
// after each sample. At a tick at position p, with the newest sample i, the rendered force R minus
// the true force F is
//
//   R(p) - F(p) = (E_i - M_i) + (M_i - F_i) + (R0(p) - F(p) - E_i + F_i) + (R(p) - R0(p)):
//
// sensing (E: estimate, M: the model's force at the true depth), model, rendering (R0: without
// delay) and link; the parts add up to the error tick by tick. For one camera M is the model's
// force at the true depth, vision is the tip's error times the stiffness, and the rest of sensing
// is contact: the position of the surface. A stereo pair measures a shape: M is its result for
// images without noise. Fingertips measure the force itself, without a model. Magnitudes of forces;
// sensor and link are ideal clocks. Throws std::invalid_argument: no simulator, a delay that is not
// 0 to 1 s; and as RunOffline.
EndToEndBudget MeasureEndToEnd(const Scene& scene, double delay, const std::stop_token& stop);

// Writes end_to_end.json and end_to_end.svg; throws std::runtime_error: not writable.
void WriteBudget(const EndToEndBudget& budget, const std::filesystem::path& folder);
std::string ToTable(const EndToEndBudget& budget);

}  // namespace palpate
