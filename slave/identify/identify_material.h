// `identify`: material constants from tables of tests, with intervals, undetermined constants, and
// the lines for a scene. The command and Python call it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "slave/identify/identify_report.h"
#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

inline constexpr double kAllStrains = 1e9;

struct IdentifyRequest {
  std::vector<std::string> data;  // KIND=FILE, KIND:RATIO=FILE or FILE, see `identify --help`
  std::filesystem::path scene;    // scene for `press=FILE`
  std::vector<std::string> overrides;
  std::string area, diameter, height;  // with units; empty: the tables contain stress and strain
  std::string ends = "free";           // or bonded
  std::string stress_unit;             // of columns that name none; empty: Pa
  std::string x, y;                    // columns; empty: found by their names
  double from = 0, to = kAllStrains;   // strains that are used [-]
  double poisson_ratio = 0.5;          // for bonded ends
  bool fit_poisson = false;            // press: estimate nu too
  double width = 0;                    // press: width of rows without one [m]
};

// Actions of the caller that need a scene.
struct IdentifyActions {
  // Called to remark on the scene's numbers; empty: not called.
  std::function<void(const Scene&)> remark;
  // The fit of `images=FILE`; empty: refused.
  std::function<ImageFit(const Scene&, const std::filesystem::path&)> fit_images;
};

// The files of the request.
std::vector<std::filesystem::path> InputFilesOf(const IdentifyRequest& request);
// Throws InputError, SceneError, std::invalid_argument, std::runtime_error: no fit; Interrupted.
IdentifyReport Identify(const IdentifyRequest& request, const IdentifyActions& actions,
                        Progress* progress);

}  // namespace palpate
