// `palpate-slave serve`: observes, estimates and answers over gRPC until it is stopped.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate {

class StopOnSignal;

struct ServeOptions {
  std::filesystem::path scene;  // empty: a set-up
  std::vector<std::string> overrides;
  std::string listen = "127.0.0.1:50051";
  bool insecure = false;
  std::filesystem::path tls;        // the folder of our certificate; empty: plain text
  std::filesystem::path state_dir;  // folder that keeps an emergency stop; empty: none
  std::string publish;              // URL of a NATS server; empty: none
  std::filesystem::path record;     // FILE.mcap, to process again; empty: none
  std::string record_limit = "8 GB";
  double record_part = 0;       // [s] after which a file ends and the next begins; 0: one file
  std::filesystem::path setup;  // folder of the scenes that clients set up; empty: none
  std::string camera = "0";     // of the set-up: number, files, video or address
  double camera_rate = 30;      // of its images [Hz]
};

// Prints `listening on HOST:PORT` when ready. SIGUSR1 is an emergency stop. Returns 0 after a stop.
// Throws SceneError for unusable scenes and std::exception for failures.
int RunServe(const ServeOptions& options, StopOnSignal& signals);

}  // namespace palpate
