// `palpate-slave health`: queries whether a running slave serves and senses. For service managers
// and containers.
#pragma once

#include <filesystem>
#include <string>

namespace palpate {

struct HealthOptions {
  std::string target = "127.0.0.1:50051";
  bool insecure = false;
  std::filesystem::path tls;  // folder of our certificate, any role; empty: plain text
  double wait = 5;            // time limit for connecting and the answer [s]
};

// Queries grpc.health.v1 for palpate.v1.Teleoperation. Prints SERVING and returns 0, or NOT_SERVING
// (no new samples) and returns 1. Throws std::runtime_error if there is no answer,
// std::invalid_argument for an unusable address or folder.
int RunHealth(const HealthOptions& options);

}  // namespace palpate
