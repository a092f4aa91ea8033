// `palpate-slave study`: the speed-accuracy trade of a scene as study.csv, study.json, study.svg
// and a table.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct StudyOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
  std::filesystem::path out;           // folder, made if it is not there
  double budget = 120;                 // of all models together [s], > 0
};

// 0: studied, or stopped after at least one answer (the files hold what there is); 1: nothing
// answered. Throws SceneError, std::invalid_argument and what writing throws.
int RunStudyCommand(const StudyOptions& options, std::stop_token stop);

}  // namespace palpate
