// `plate-large`: a clamped circular plate that bends and stretches, by the von Karman equations
// with an immovable edge, from small deflections to the membrane limit.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/modal_plate.h"
#include "slave/mechanics/plate/plate_modes.h"
#include "slave/mechanics/plate/plate_surface.h"
#include "slave/mechanics/plate/round_press.h"
#include "slave/program/progress.h"

namespace palpate {

// Contacts as for PlateModel. One contact at the centre is solved to nine digits
// (round_press.h); all others in modes (modal_plate.h), whose error falls with `order`. At order
// 12, against order 24, up to |w| = 10 t, at a given depth: 0.7 % of the force within half the
// radius; at 0.8 of it 1 % at t, 4 % at 5 t and 10 % at 10 t, beyond the range. The shape around
// the load is found less well: a force sought from it is 4 % low at 0.7 of the radius at 5 t, 8 %
// at half of it at 10 t (see load_fit.h).
//
// Error of the law, independent of the order: moderate rotations, linear elasticity, no shear.
// Against a neo-Hookean solid, 1 mm of rubber with a radius of 39 mm under a tool of 4 mm, 5 mm
// deep, the force at that depth is high by 7 % at the centre, 8 % at 0.3, 9 % at 0.5, 13 % at 0.7
// and 17 % at 0.8 of the radius; at 0.5 mm thickness by 5 to 6 %, at 2 mm by 12 to 31 %.
// plate_law.h states it for all cases; errors above 10 % are kExtrapolated.
//
// Newton's method from the last solution. Beyond |w| = 0.3 a rotations are not moderate any more:
// kExtrapolated; the same where the law's error in the solution, a force or the deflection under a
// force, is beyond 10 % (plate_law.h). A new diameter takes tens of milliseconds and memory.
class PlateLargeModel final : public PlateSurface {
 public:
  struct Params {
    double radius = 0;         // a [m], > 0
    double thickness = 0;      // t [m], 0 < t <= a / 10
    double young_modulus = 0;  // E [Pa], > 0
    double poisson_ratio = 0;  // nu [-], -1 < nu <= 0.5
    double prestress = 0;      // tension at rest N0 [N/m], >= 0
    int order = 12;            // of the modes: even, 2 to 40; cost of an update about order^4
    // Largest |w| / t that is not `extrapolated` for a contact near the centre; at the radius p
    // [radii] it is reduced by (1 - p^2)^2, the relative compliance of the plate there; exactly at
    // the centre it is ten times larger.
    double range = 20;
  };

  // Throws std::invalid_argument naming the parameter, its value and what is accepted; Interrupted.
  explicit PlateLargeModel(const Params& params, Progress* progress = nullptr);

  void Reset() override;
  [[nodiscard]] const Params& params() const { return params_; }

 private:
  struct Pressed {  // precomputed data of contacts of one radius and face
    std::shared_ptr<const plate::ShortWaves> waves;
    plate::RoundPress central;
  };

  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses) override;
  void Prepare();
  void Orient();
  Pressed& ToolOf(double load_radius, plate::Face face);
  bool SolveCentral();
  [[nodiscard]] ContactResponse ResponseOf(const Contact& contact, std::size_t touch) const;
  [[nodiscard]] double DisplacementAt(const Eigen::Vector2d& x) noexcept override;

  Params params_;
  double force_unit_ = 0;  // E t^4 / a^2 [N]
  double prestress_ = 0;   // in units of E t^3 / a^2
  plate::PlateModes modes_;
  plate::ModalPlate modal_;
  std::vector<std::unique_ptr<Pressed>> tools_;
  std::vector<plate::ModalPlate::Press> presses_;
  std::vector<double> values_;  // nondimensional
  Eigen::Vector2d axis_{1, 0};  // x axis of the frame of modal_, in O
  plate::Symmetry symmetry_ = plate::Symmetry::kMirror;
  Pressed* central_ = nullptr;  // one contact at the centre: its tool
  bool shaped_ = false;         // modal_ has solved the contact at the centre
};

}  // namespace palpate
