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
  std::filesystem::path out;           // folder, created if missing; empty: `merge`
  double budget = 120;                 // of all models together, or of a shard's [s], > 0
  std::string shard;                   // i/n: only this part, as a file in `out`; empty: all
  std::filesystem::path merge;         // folder of all parts, to be put together; empty: measure
  // Instead: the error budget of the rendered force, as end_to_end.json, end_to_end.svg and a
  // table.
  bool end_to_end = false;
  double delay = 0.02;  // of its link [s]
};

// 0: studied, or stopped after at least one result (the files contain it); 1: no result, or a shard
// that was stopped. Throws
// SceneError, std::invalid_argument and exceptions of writing.
int RunStudyCommand(const StudyOptions& options, const std::stop_token& stop);

}  // namespace palpate
