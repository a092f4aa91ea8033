// What `palpate-slave`'s commands take and do; of those with more to say: train/train.h.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

class StopOnSignal;

// `palpate-slave process`: the pipeline over recorded sources as fast as they go.
struct ProcessOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::filesystem::path out;
  bool pictures = false;           // also write pictures with what was seen drawn in
  bool frames = false;             // also write pictures as they came
  bool points = false;             // also write the points that are followed
  std::optional<double> duration;  // of a simulated target's path [s]
};

// Writes out/states.csv and out/summary.json, prints a summary for people. 0: done. Throws
// SceneError and std::exception. Where `scene` is a recording (FILE.mcap), its states are made anew
// and held against those recorded.
int RunProcess(const ProcessOptions& options, const std::stop_token& stop);

// `palpate-slave serve`: watches, computes, answers over gRPC until told to stop.
struct ServeOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::string listen = "127.0.0.1:50051";
  bool insecure = false;
  std::filesystem::path tls;        // the folder of our certificate; empty: plain text
  std::filesystem::path state_dir;  // where an emergency stop is kept; empty: nowhere
  std::string metrics;              // HOST:PORT that tells health in numbers; empty: none does
  std::filesystem::path record;     // FILE.mcap, to process again; empty: none
  std::string record_limit = "8 GB";
  double record_part = 0;  // [s] after which a file ends and the next begins; 0: one file
};

// Prints `listening on HOST:PORT` when ready. SIGUSR1 is an emergency stop. Returns 0 when told to
// stop; throws SceneError for
// unusable scenes and std::exception for what failed.
int RunServe(const ServeOptions& options, StopOnSignal& signals);

// `palpate-slave study`: the speed-accuracy trade of a scene as study.csv, study.json, study.svg
// and a table.
struct StudyOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
  std::filesystem::path out;           // folder, made if it is not there
  double budget = 120;                 // of all models together [s], > 0
  // Instead: what each stage adds to the felt force's error, as end_to_end.json, end_to_end.svg and
  // a table.
  bool end_to_end = false;
  double delay = 0.02;  // of its link [s]
};

// 0: studied, or stopped after at least one answer (the files hold what there is); 1: nothing
// answered. Throws SceneError, std::invalid_argument and what writing throws.
int RunStudyCommand(const StudyOptions& options, std::stop_token stop);

// `palpate-slave solve`: contacts and loads in, forces and displacements out, as CSV files
// (contracts, `solve`).
struct SolveOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
  std::filesystem::path contacts;      // CSV; empty: none
  std::filesystem::path loads;         // CSV; empty: none
  std::filesystem::path out;           // CSV
  std::filesystem::path field;         // VTU; empty: none
};

// Returns the exit code: 0 done; 1 a case failed (the file is written, its rows say `failed`),
// writing did, or it was stopped (what was solved is written); 2 unusable files or scene, with
// `file:line: ...` on standard error.
int RunSolve(const SolveOptions& options, const std::stop_token& stop = {}) noexcept;

// `palpate-slave check`: what will run and why, what is off, and what may be expected of it.
struct CheckOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
};

// Prints the report; 0: the scene can run. Throws SceneError and std::exception.
int RunCheck(const CheckOptions& options);

}  // namespace palpate
