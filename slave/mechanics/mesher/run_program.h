// Runs a program without a shell, and never waits for it longer than was allowed.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

// Where PATH leads to an executable file of that name; nullopt: nowhere.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

struct ProgramEnd {
  int status = 0;      // exit status; 128 + signal if a signal ended it
  std::string output;  // the last 4000 characters of its standard output and error
};

// Runs `program` in `folder`, which gets a file `log`, in the C locale, with an empty standard
// input. After `timeout`, or when `stop` is requested, the program and what it started are killed.
// Throws std::runtime_error: it cannot be started, it took too long; Interrupted: `stop`.
ProgramEnd RunProgram(const std::filesystem::path& program,
                      const std::vector<std::string>& arguments,
                      const std::filesystem::path& folder, std::chrono::milliseconds timeout,
                      const std::stop_token& stop);

}  // namespace palpate
