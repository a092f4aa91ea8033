// `palpate-master doctor`: what link, clock, priorities and device allow, and what to change.
#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "master/doctor/finding.h"
#include "master/link/slave_link.h"

namespace palpate {

class Device;

// Of the device that is in use.
Finding FoundOf(const Device& device);
// What is known of the device, of this machine and, if there is one, of the line, as an observer of
// the slave; the bad last. Takes two measurements of `seconds`, or ends where `stop` is asked for:
// what was found means nothing then.
Findings Examine(Finding device, const std::optional<SlaveLink::Options>& line, double seconds,
                 const std::stop_token& stop = {});

struct DoctorOptions {
  std::optional<SlaveLink::Options> line;  // nullopt: this machine alone
  std::string device = "sim-hand";
  double seconds = 2;  // of each measurement [s], > 0
};

// Prints what was found, the bad last. 0: nothing is bad; 1: something is.
int RunDoctor(const DoctorOptions& options);

}  // namespace palpate
