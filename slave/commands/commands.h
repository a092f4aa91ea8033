// Options and entry points of `palpate-slave`'s commands. Larger commands have their own header,
// for example train/train.h.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

class StopOnSignal;

// `palpate-slave process`: runs the pipeline on recorded sources as fast as possible.
struct ProcessOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::filesystem::path out;
  bool pictures = false;           // also write images with the detections drawn in
  bool frames = false;             // also write the source images
  bool points = false;             // also write the points that are followed
  std::optional<double> duration;  // of a simulated target's path [s]
};

// Writes out/states.csv and out/summary.json, and prints a summary. 0: done. Throws SceneError and
// std::exception. If `scene` is a recording (FILE.mcap), its states are recomputed and compared
// with the recorded ones.
int RunProcess(const ProcessOptions& options, const std::stop_token& stop);

// `palpate-slave serve`: observes, estimates and answers over gRPC until it is stopped.
struct ServeOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::string listen = "127.0.0.1:50051";
  bool insecure = false;
  std::filesystem::path tls;        // the folder of our certificate; empty: plain text
  std::filesystem::path state_dir;  // folder that keeps an emergency stop; empty: none
  std::string metrics;              // HOST:PORT that serves metrics; empty: none
  std::filesystem::path record;     // FILE.mcap, to process again; empty: none
  std::string record_limit = "8 GB";
  double record_part = 0;  // [s] after which a file ends and the next begins; 0: one file
};

// Prints `listening on HOST:PORT` when ready. SIGUSR1 is an emergency stop. Returns 0 after a stop.
// Throws SceneError for unusable scenes and std::exception for failures.
int RunServe(const ServeOptions& options, StopOnSignal& signals);

// `palpate-slave study`: the speed-accuracy trade of a scene as study.csv, study.json, study.svg
// and a table.
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

// Returns the exit code: 0 done; 1 a case failed (the file is written, its rows have `failed`),
// writing failed, or it was stopped (the solved rows are written); 2 unusable files or scene, with
// `file:line: ...` on standard error.
int RunSolve(const SolveOptions& options, const std::stop_token& stop = {}) noexcept;

// `palpate-slave check`: what will run and why, what is off, and the expected accuracy.
struct CheckOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
};

// Prints the report; 0: the scene can run. Throws SceneError and std::exception.
int RunCheck(const CheckOptions& options);

}  // namespace palpate
