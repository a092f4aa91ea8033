// A row of the table of promises: the disturbances of a scene's devices, and what operator and
// observers must receive.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace palpate::promises {

// From a time on, until another disturbance of the same kind. All are absent at first.
struct Disturbance {
  double at = 0;  // since the first sample [s]
  // Cameras. `side`: 0 left or only camera, 1 right; both without one.
  std::optional<int> side;
  std::optional<Eigen::Vector2d> shift_px;  // of the images, x right, y down
  std::optional<double> grow;               // scale factor of the image about its centre
  std::optional<double> light;              // factor of the grey levels
  std::optional<double> blur_px;            // sigma
  std::optional<double> noise;              // sigma [grey levels]
  std::optional<std::string> cover;         // tip, contact, object (all but the tip), image, none
  std::optional<int> late;                  // samples that the image is late
  std::optional<bool> exchanged;            // left and right image
  std::optional<double> delay_s;            // of the images, as their driver states it
  // All sensors; `frozen` of one camera with `side`.
  std::optional<bool> frozen, silent;
  // Fingertips: of the first one.
  std::optional<int> channel;         // channel; absent: all channels
  std::optional<double> value, add;   // replaces the reading; is added to the reading
  std::optional<double> most;         // larger readings are cut off here
  std::optional<bool> stuck, absent;  // the reading stays constant; the fingertip sends no samples
  std::optional<bool> poses;          // samples contain the true pose, as from a tracked hand
  // Manipulator.
  std::optional<Eigen::Vector3d> encoders_m;  // more than the true tip, S
  std::optional<double> encoders_scale;       // reported way since then, relative to the true one
  std::optional<bool> driver;                 // the driver sends reports
  std::optional<bool> reconnects;             // the driver's stream ends and begins again
  // Calls that are made once. `reset`: the required answer to ReinitializeTracking: accepted or
  // refused.
  std::optional<std::string> reset;
  // engage in a new epoch, follow, clutch, silence, blind (no newer state), leave; or strokes into
  // the surface, each in an epoch of its own: inwards, zigzag, sideways (from 0.8 of a guard)
  std::optional<std::string> operates;
  std::optional<double> pause_s;              // between strokes
  std::optional<Eigen::Vector3d> command_m;   // the device's position from now on, M
  std::optional<Eigen::Vector3d> device_m_s;  // the device's velocity from now on, M
  std::optional<int> resent;                  // each command is followed by the one before so many
  std::optional<int> watch_every;             // ticks of 2 ms between two looks of the watchdog
  std::optional<bool> stop;                   // emergency stop; false: reset of the newest
  std::optional<int> reset_of;                // reset of this stop, from 1; it may be refused
};

// Required states for samples within [from, to], times as above. Absent members are not compared.
struct Expectation {
  double from = 0, to = 1e9;
  std::optional<std::string> check, validity;  // of at least `share` of the states
  double share = 1;
  std::optional<std::string> never;  // a check that no state has
  // True: the force is known in `share` of the states; false: it is unknown.
  std::optional<bool> force;
  std::optional<double> force_error;  // largest of a valid force, parts of the true peak
  std::optional<std::array<double, 2>> force_peak;  // range of the largest known force [N]
  std::optional<double> tip_error_m;                // largest of the tip
  std::optional<double> tip_travel_m;  // smallest of the largest distance from the first tip
  // Range of the largest true force or depth, relative to its guard.
  std::optional<std::array<double, 2>> guards;
  // Ranges of the largest true depth below the surface at rest, and of the largest distance of the
  // tool from where the operator leads it while FOLLOWING.
  std::optional<std::array<double, 2>> depth_m, off_target_m;
  std::optional<std::array<double, 2>> age_s;  // range, since the sample was taken
  std::optional<std::array<double, 2>> sigma;  // range of all known sigmas [N]
  // Range of the rms of error / sigma of valid forces in contact [-].
  std::optional<std::array<double, 2>> error_by_sigma;
  std::optional<std::string> event;  // of one state at least
  std::optional<std::string> phase;  // of `share` of the states
  std::optional<std::string> alarm;  // part of an alarm at the last state
  std::optional<bool> alarms;        // whether there is an alarm at the last state
};

struct Row {
  std::string name;
  std::filesystem::path page;  // below the project's root
  std::string promise;         // the sentence, or a part of it, as it is on the page
  std::filesystem::path scene;
  std::vector<std::string> site;    // overrides of the scene, for its devices and the slave
  std::vector<std::string> stated;  // overrides of the slave's scene only
  bool is_blind = false;            // CHECKS.md lists the error as undetectable
  bool is_full = false;             // run by `tests/run.sh --full` only
  // The tool goes where the slave aims it, for this time [s]. Absent: a scripted press.
  std::optional<double> follows_s;
  std::vector<Disturbance> events;  // sorted by time
  std::vector<Expectation> expected;
};

// Throws std::invalid_argument: the row and the key that cannot be read.
std::vector<Row> ReadRows(const std::filesystem::path& file);

}  // namespace palpate::promises
