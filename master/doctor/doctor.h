// `palpate-master doctor`: what link, clock, priorities and device allow, and what to change.
#pragma once

#include <optional>
#include <string>

#include "master/link/slave_link.h"

namespace palpate {

struct DoctorOptions {
  std::optional<SlaveLink::Options> line;  // nullopt: this machine alone
  std::string device = "sim-hand";
  double seconds = 2;  // of each measurement [s], > 0
};

// Prints what was found, the bad last. 0: nothing is bad; 1: something is.
int RunDoctor(const DoctorOptions& options);

}  // namespace palpate
