// Young's modulus, and optionally Poisson's ratio, of a scene's object from contacts with a known
// force, or from its sag under gravity and known loads. Static forces are proportional to E, so one
// solution per contact is enough, unless the body is under tension at rest. A sag is nearly
// proportional to 1 / E, so few solutions are enough.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

struct PressFit {
  double young_modulus = 0, sigma_modulus = 0;  // [Pa]; sigma contains model_error
  double model_error = 0;    // stated error of the model's answers, all of the same sign [-]
  double poisson_ratio = 0;  // of the scene, or estimated
  bool sought_poisson = false;
  double sigma_poisson = 0;  // [-]
  double rms = 0;            // of the forces or displacements, over the largest [-]
  // For each load its name and the modulus from this load only [Pa].
  std::vector<std::pair<std::string, double>> alone{};
  int presses = 0;                 // presses or loads that were fitted
  int extrapolated = 0;            // cases with a row that is not valid
  std::string_view flag_reason{};  // of the first such row
  std::string kind;                // of the model
  std::string remark;              // on places off the surface; may be empty
};

// `file` is a table of contacts that `solve` reads, with the measured forces fx, fy, fz, or one
// that it wrote; frame O. A contact or column that `solve` would refuse is refused, and a contact
// without a width. `width` [m] applies to rows without one; 0: that of the scene's tool. Throws
// InputError `file:line: ...`, std::invalid_argument, Interrupted; std::runtime_error: the model
// has no solution.
PressFit FitPress(const Scene& scene, const std::filesystem::path& file, double width,
                  bool seek_poisson, Progress* progress);

// From rows `case,x,y,z[,fx,fy,fz][,dx,dy,dz][,width]`: loads of the tool on the object [N], none
// without a number, and measured displacements from the unloaded shape [m], each component where
// there is a number. A measured point without load has a row without a force. Gravity is the
// scene's. Throws the exceptions of FitPress.
PressFit FitLoads(const Scene& scene, const std::filesystem::path& file, double width,
                  Progress* progress);

}  // namespace palpate
