// Connects a simulated environment to a slave as the devices of a laboratory are connected.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

struct StreamingTarget {
  std::string address;  // HOST:PORT
  // Folder with folders `sensor` and `arm`, each with ca.pem, cert.pem and key.pem for this role;
  // empty: plain text.
  std::filesystem::path tls;
};

// Sends images (FeedImages) or tactile samples (FeedTactile) at the scene's rate, and moves the
// tool to the targets of DriveTool, until `stop` is requested. Prints `streaming to HOST:PORT` once
// the slave has its baseline or rest shape and drives the tool. If the scene's manipulator is a
// stream, another driver moves the tool: then it first prints `tool on HOST:PORT`, see ToolSocket.
// Logs after 5 s which inputs the slave still lacks, and the delay from a sample to its sending.
// Throws palpate::Error: the slave cannot be reached, or rejects something.
void StreamTo(const StreamingTarget& target, const Scene& scene, SimulatedEnvironment& environment,
              const std::stop_token& stop);

}  // namespace palpate
