// `palpate-slave study`: the speed-accuracy trade of a scene as study.csv, study.json and a
// table.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct StudyOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
  std::filesystem::path out;           // folder, created if missing
  double budget = 120;                 // of all models together [s], > 0
};

// Returns 0 if studied, or stopped after at least one result (the files contain it), and 1 without
// a result. Throws SceneError, std::invalid_argument and exceptions of writing.
int RunStudyCommand(const StudyOptions& options, const std::stop_token& stop);

}  // namespace palpate
