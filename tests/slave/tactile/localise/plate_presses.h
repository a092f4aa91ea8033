// Presses on a plate with a known normal (../shared/data/biotac_contact_direction), and the error
// of a localiser on them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/localise/localiser.h"

namespace palpate::presses {

struct Presses {
  std::vector<TactileSignals> change;  // rows in contact; rest: the median of the others
  std::vector<FingerReading> raw;
  // Outward at the contact: the normal of the data, multiplied by diag(-1, 1, -1).
  std::vector<Eigen::Vector3d> normal_F;
};

// `file` without `.csv`; contact where pdc >= `least_pdc`. nullopt where the data are absent.
std::optional<Presses> Read(const std::string& file, double least_pdc);
// The authors' press of a foam bar (../shared/data/seed001_rf_foam_bar), rows with pdc 20 counts
// above rest; as normal, the direction of the force that their network gives. nullopt: absent.
std::optional<Presses> ReadSoftPress();
// The authors' electrodes. nullopt where the data are absent.
std::optional<ElectrodeLayout> Layout();

struct Errors {
  std::vector<double> degrees;   // sorted errors of the rows where a place was found
  std::vector<double> of_sigma;  // sorted errors divided by the place's own sigma
  int rows = 0;
  [[nodiscard]] double median() const { return degrees.at((degrees.size() - 1) / 2); }
};
// Angles between located and measured normals after the one rotation that aligns them best (least
// squares).
Errors ErrorsOf(const Localiser& localiser, const Presses& presses);

}  // namespace palpate::presses
