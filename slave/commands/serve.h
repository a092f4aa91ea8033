// `palpate-slave serve`: watches, computes, answers over gRPC until told to stop.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct ServeOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::string listen = "127.0.0.1:50051";
  bool insecure = false;
};

// Prints `listening on HOST:PORT` when ready. Returns 0 after `stop`; throws SceneError for
// unusable scenes and std::exception for what failed.
int RunServe(const ServeOptions& options, const std::stop_token& stop);

}  // namespace palpate
