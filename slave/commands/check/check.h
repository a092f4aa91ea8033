// `palpate-slave check`: what will run and why, what is off, and what may be expected of it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate {

struct CheckOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
};

// Prints the report; 0: the scene can run. Throws SceneError and std::exception.
int RunCheck(const CheckOptions& options);

}  // namespace palpate
