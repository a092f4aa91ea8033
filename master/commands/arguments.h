// Command lines of palpate-master.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "master/commands/replay_command.h"
#include "master/doctor/doctor.h"
#include "master/link/slave_link.h"
#include "master/motion/operator_motion.h"

namespace CLI {
class App;
}

namespace palpate {

struct Arguments {
  SlaveLink::Options link;
  std::string device;  // empty: sim-hand where arm and object are simulated, else none: observe
  std::string render = "local";
  double duration = 0;
  double force_limit = 3.3, slew_limit = 0.2;  // the master's own [N], [N/ms]
  std::string axes = "x,y,z", lock, box;
  std::vector<std::string> fixtures;
  double contact_speed = 0;  // [mm/s]; 0: no limit
  int clutch_button = 2;     // from 1; 0: none
  std::filesystem::path report, log, record;
  std::string record_limit = "8 GB";
  double record_part = 0;           // [s]; 0: one file
  std::string reason;               // of evict
  bool views = false;               // whether the page is served
  std::string view;                 // HOST:PORT; empty: a free loopback port
  std::filesystem::path setup_tls;  // of the page's set-up; empty: link.tls
  ReplayOptions replay;
};

struct DoctorArguments {
  SlaveLink::Options link;  // an empty target: this machine alone
  DoctorOptions options;
};

// Declares every command and option.
void Declare(CLI::App* app, Arguments* a, DoctorArguments* doctor);

// The operator's motion settings. Throws std::invalid_argument that names the option.
MotionOptions MotionOf(const Arguments& a);

// Returns whether `--device pointer` is chosen.
inline bool IsPointer(const Arguments& a) {
  return a.device == "pointer";
}

// Returns whether the device can be made only when the scene is known.
inline bool IsMadeForScene(const Arguments& a) {
  return a.device.empty() || a.device == "sim-hand" || IsPointer(a);
}

// Throws std::invalid_argument where the certificates in this folder cannot be used now.
void RequireTimely(const std::filesystem::path& certificates);
// Checks everything of `connect` that can fail before anything moves. Throws std::invalid_argument
// that names the option.
void CheckBeforehand(const Arguments& a);

}  // namespace palpate
