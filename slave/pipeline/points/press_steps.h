// A press that halts at depth after depth, as paper C's experiment (5.1, figures 5 and 6): what was
// felt at each halt beside what was true.
#pragma once

#include <optional>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "slave/pipeline/points/point_errors.h"

namespace palpate {

// One halt.
struct PressStep {
  double depth = 0;        // true, of the tool [m]
  double true_force = 0;   // size [N]
  int pairs = 0;           // of pictures with a known force
  double force = 0;        // estimated, mean of their sizes [N]
  double force_error = 0;  // the largest |estimated - true| of a pair [N]
  ErrorOfPoints displacement;
};

// Sorts pairs into steps: those in a row at one true depth.
class PressSteps {
 public:
  // The points' errors of the pair that Add() tells next.
  void Add(const Eigen::Vector3d& displacement_error) { points_.push_back(displacement_error); }
  // `force`: size [N]; nullopt: unknown.
  void Add(double depth, double true_force, const std::optional<double>& force);
  // Those that lasted for three pairs or more with a known force, up to the deepest: on the way
  // back a press does not halt, but it ends somewhere.
  [[nodiscard]] std::vector<PressStep> steps() const;

 private:
  std::vector<PressStep> steps_;
  std::vector<Eigen::Vector3d> points_;
};

// As summary.json has them.
nlohmann::ordered_json ToJson(const std::vector<PressStep>& steps);

}  // namespace palpate
