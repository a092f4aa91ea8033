// Limits of plate models and of the simulated membrane, so that mistakes are reported where they
// are written.
#pragma once

#include <string>

#include "slave/scene/scene.h"
#include "slave/scene/section.h"

namespace palpate {

// Uses the parts of the scene that were already read: `object` and `sense` for widths, all parts
// for the other limits. The texts state the accepted values.
class MembraneLimits {
 public:
  static constexpr double kMaxBlur = 20;  // of a simulated pair [px]
  static constexpr const char* kBlur = "0 to 20 px with a simulated pair";

  explicit MembraneLimits(const Scene& scene);

  // Returns whether the object is a membrane in front of a simulated pair.
  [[nodiscard]] bool apply() const { return radius_ > 0 && thickness_ > 0; }
  [[nodiscard]] bool is_simulated() const { return is_simulated_; }

  // The rule of the tool's width; any positive width where no limits apply. Lives as long as this.
  [[nodiscard]] Rule width_rule() const;

  [[nodiscard]] bool allows_thickness() const;
  [[nodiscard]] std::string thickness() const;
  // The limits of simulated membranes.
  [[nodiscard]] bool allows_prestress() const;
  [[nodiscard]] std::string prestress() const;
  [[nodiscard]] bool allows_press() const;
  [[nodiscard]] std::string press() const;
  [[nodiscard]] bool allows_home() const;
  [[nodiscard]] std::string home() const;

 private:
  [[nodiscard]] double max_prestress() const;  // [N/m]
  [[nodiscard]] double max_press() const;      // [m]
  [[nodiscard]] double reach() const;          // of the tool's axis from the membrane's [m]

  const Scene& scene_;
  double radius_ = 0, thickness_ = 0;
  bool is_simulated_ = false;
  double min_width_ = 0, max_width_ = 0;
  std::string widths_;
};

}  // namespace palpate
