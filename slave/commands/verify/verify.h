// `palpate-slave verify`: compares measured with estimated forces. A scene's run makes the table of
// both that is compared.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/verify/force_table.h"

namespace palpate {

struct VerifyOptions {
  std::filesystem::path scene;  // or a slave's recording, FILE.mcap; empty: `forces` of any source
  std::vector<std::string> overrides;
  std::filesystem::path forces;  // table of both forces; empty: a run of the scene makes it
  ForceColumns columns;          // of `forces`
  std::filesystem::path out;
  std::filesystem::path loads;   // CSV file; empty: see `sensor`, else the user is asked
  bool sensor = false;           // the states have the force of a sensor
  std::filesystem::path states;  // states.csv; empty: `connect`, else SCENE is processed
  std::string connect;           // HOST:PORT of a slave
  std::filesystem::path tls;     // folder of certificates
  bool insecure = false;
  double duration = 60;  // for which a slave is watched [s]
  double hold = 3;       // duration for which a load is held after a prompt [s]
};

// Writes report.json, and forces.csv if a run of the scene makes it. 0: every tested quantity is
// right; 1: it is not, or the loads do not decide it. Throws SceneError, InputError,
// std::invalid_argument: unusable input; std::runtime_error: the slave does not answer.
int RunVerify(const VerifyOptions& options, const std::stop_token& stop);

}  // namespace palpate
