// `shell`: a fluid-filled thin shell as alternative to the solid disc, for one rigid tool that
// moves along the normal, opposite to the holder. The solutions of FluidShell are tabulated once
// per width of the tool; the visible outline is the shell's meridian.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/shell/fluid_shell.h"

namespace palpate {

// One contact that prescribes a displacement; others fail. Across the normal the shell gives no
// force. A tool that moves across, pulls, or is not opposite to the holder gives kExtrapolated. A
// width that was not tabulated takes about a second: Prefetch.
class ShellModel final : public DeformationModel {
 public:
  struct Params {
    FluidShell::Params shell;   // its tool_radius is not read
    double held_direction = 0;  // of the fixed cap's middle from the centre [rad]
    double tool_width = 0;      // tabulated at once [m]; 0: none
    double range = 0.1;         // largest |displacement| / diameter before `extrapolated` [-]
  };

  // `mesh`: the outline, a disc about the origin. Throws std::invalid_argument: see FluidShell;
  // range not positive.
  ShellModel(BoundaryMesh mesh, const Params& params);

  void Prefetch(std::span<const Contact> contacts) override;

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  struct Table {
    double width = 0, step = 0;        // [m]
    std::vector<double> force, slope;  // [N], [N/m] at multiples of `step`
    std::vector<FluidShell::Meridian> meridian;
  };

  Table& TableFor(double width);
  [[nodiscard]] double WidthOf(const Contact& contact) const;
  bool Answer(const Contact& contact, ContactResponse* response);
  [[nodiscard]] Eigen::Vector2d MeridianMove(double angle) const;

  BoundaryMesh mesh_;
  Params params_;
  std::vector<Table> tables_;
  // Of the last solution.
  const Table* shown_ = nullptr;
  double depth_ = 0;  // [m]
  Eigen::Vector2d normal_O_{0, 1};
};

}  // namespace palpate
