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
  std::filesystem::path out;           // folder, created if missing
  double budget = 120;                 // of all models together [s], > 0
  // Instead: the error budget of the rendered force, as end_to_end.json, end_to_end.svg and a
  // table.
  bool end_to_end = false;
  double delay = 0.02;  // of its link [s]
};

// 0: studied, or stopped after at least one result (the files contain it); 1: no result. Throws
// SceneError, std::invalid_argument and exceptions of writing.
int RunStudyCommand(const StudyOptions& options, const std::stop_token& stop);

}  // namespace palpate
