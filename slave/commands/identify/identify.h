// `palpate-slave identify`: constants of materials from tests in tables, with intervals, what
// cannot be told, and the lines of a scene that they make.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct IdentifyOptions {
  std::vector<std::string> data;  // KIND=FILE, KIND:RATIO=FILE or FILE, see kIdentifyHelp
  std::filesystem::path out;      // folder, made if it is not there
  std::filesystem::path scene;    // of `press=FILE`
  std::vector<std::string> overrides;
  std::string area, diameter, height;  // with units; empty: the tables hold stress and strain
  std::string ends = "free";           // or bonded
  std::string stress_unit;             // of columns that name none; empty: Pa
  std::string x, y;                    // columns; empty: found by their names
  double from = 0, to = 1e9;           // strains that are used [-]
  double poisson_ratio = 0.5;          // for bonded ends
  bool foam = false;                   // compressible laws
  bool fit_poisson = false;            // press: nu too
  double width = 0;                    // press: of rows that have none [m]
};

extern const char* const kIdentifyHelp;  // what --help says below the options

// Writes report.json, identify.svg and, where there are, predictions.csv into `out`; prints what it
// found. 0: done. Throws InputError, SceneError, std::invalid_argument, what writing throws, and
// Interrupted.
int RunIdentify(const IdentifyOptions& options, const std::stop_token& stop);

}  // namespace palpate
