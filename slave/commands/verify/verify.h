// `palpate-slave verify`: the force test card of a set-up.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/commands/verify/force_pairs.h"
#include "slave/commands/verify/known_loads.h"

namespace palpate {

struct VerifyOptions {
  std::filesystem::path scene;  // or a slave's recording, FILE.mcap
  std::vector<std::string> overrides;
  std::filesystem::path forces;  // CSV of pairs; no scene then
  ForceColumns columns;
  std::filesystem::path out;
  std::filesystem::path loads;   // CSV; empty: see `sensor`, else questions
  bool sensor = false;           // the states have the force of a sensor
  std::filesystem::path states;  // states.csv; empty: `connect`, else SCENE is processed
  std::string connect;           // HOST:PORT of a slave
  std::filesystem::path tls;     // folder of certificates
  bool insecure = false;
  double duration = 60;  // for which a slave is watched [s]
  double hold = 3;       // for which a load is held in answer to a question [s]
};

// Writes report.json, states.csv and loads.csv (if there were questions). 0: every
// tested quantity is right; 1: it is not, or the loads do not decide it. Throws SceneError,
// InputError, std::invalid_argument: unusable input; std::runtime_error: the slave does not answer.
int RunVerify(const VerifyOptions& options, const std::stop_token& stop);

// A load as a user describes it: `weight 100 g +y`, `spring 200 N/m 5 mm +y`, `force 0 1.2 0`,
// `press 3 mm`, `none`; with `at X Y Z` [m] behind it where the tip is known. Directions are those
// in which the object pushes the tool. Throws std::invalid_argument with what is accepted.
KnownLoad ParseLoad(const std::string& line);

}  // namespace palpate
