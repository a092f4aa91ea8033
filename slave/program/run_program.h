// Runs a program without a shell, and never waits for it longer than was allowed.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

// Returns the executable file of that name in PATH; nullopt: none.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

struct ProgramEnd {
  int status = 0;      // exit status; 128 + signal if a signal ended it
  std::string output;  // the last 4000 characters of its file `log`
};

// A program that runs in `folder`, in the C locale, with an empty standard input. Its standard
// error goes to the file `log` there, its standard output to the file descriptor `output`, or to
// `log` as well if that is -1. The destructor kills it and its child processes.
class RunningProgram {
 public:
  // Throws std::runtime_error: it cannot be started.
  RunningProgram(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                 std::filesystem::path folder, int output);
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  // nullopt: it still runs.
  std::optional<ProgramEnd> Ended();
  // Waits for its end.
  ProgramEnd Wait();
  // Thread-safe.
  void Kill() const;

 private:
  ProgramEnd End(int status);

  std::filesystem::path folder_;
  int pid_;
  bool ended_ = false;
};

// Runs `program` in `folder` as above, with all output in `log`. After `timeout`, or when `stop` is
// requested, the program and what it started are killed. Throws std::runtime_error: it cannot be
// started, it took too long; Interrupted: `stop`.
ProgramEnd RunProgram(const std::filesystem::path& program,
                      const std::vector<std::string>& arguments,
                      const std::filesystem::path& folder, std::chrono::milliseconds timeout,
                      const std::stop_token& stop);

}  // namespace palpate
