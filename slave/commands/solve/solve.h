// `palpate-slave solve`: contacts and loads in, forces and displacements out, as CSV files
// (rules: slave/solve/README.md).
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct SolveOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
  std::filesystem::path contacts;      // CSV; empty: none
  std::filesystem::path loads;         // CSV; empty: none
  std::filesystem::path out;           // CSV
  std::filesystem::path field;         // VTU; empty: none
  bool independent = false;            // each row acts alone, independent of its case
  bool follows_path = false;           // each case starts where the last one ended, not from rest
  bool moments = false;                // `out` gets the columns mx, my, mz
};

// Returns the exit code: 0 done; 1 a case failed (the file is written, its rows have `failed`),
// writing failed, or it was stopped (the solved rows are written); 2 unusable files or scene, with
// `file:line: ...` on standard error.
int RunSolve(const SolveOptions& options, const std::stop_token& stop = {}) noexcept;

}  // namespace palpate
