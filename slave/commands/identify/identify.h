// `palpate-slave identify`: material constants from tables of tests, with intervals, undetermined
// constants, and the lines for a scene.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

inline constexpr double kAllStrains = 1e9;

struct IdentifyOptions {
  std::vector<std::string> data;  // KIND=FILE, KIND:RATIO=FILE or FILE, see kIdentifyHelp
  std::filesystem::path out;      // folder, created if missing
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

extern const char* const kIdentifyHelp;  // text of --help below the options

// Writes report.json into `out` and prints the results. 0: done. Throws InputError, SceneError,
// std::invalid_argument, exceptions of writing, and Interrupted.
int RunIdentify(const IdentifyOptions& options, const std::stop_token& stop);

}  // namespace palpate
