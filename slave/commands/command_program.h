// Commands of `palpate-slave` that are separate programs, and helpers for their main functions.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "shared/program/command_line.h"

namespace palpate {

// `palpate-slave COMMAND` executes this program. Commands with special libraries have a separate
// program, so that no other command loads these libraries.
struct CommandProgram {
  std::string_view command;
  const char* program;
  const char* description;
  const char* libraries;  // argument of deploy/install.sh that installs its libraries; empty: none
};
inline constexpr CommandProgram kCommandPrograms[] = {
    {"demo", "palpate-demo",
     "Run slave and master: a simulated operator presses a simulated object", ""},
    {"study", "palpate-tools", "Measure speed and accuracy of every model that fits the scene", ""},
    {"precompute", "palpate-tools", "Fill the cache of Green's functions of fem-green", ""},
    {"identify", "palpate-tools", "Identify material constants from tables of tests", ""},
    {"evaluate", "palpate-evaluate", "Compare the estimated shape with a measured point cloud",
     "clouds"},
    {"verify", "palpate-verify", "Test force, sign, frame and sigma with known loads", ""},
    {"calibrate", "palpate-tools",
     "Calibrate lens, stereo rig and pose of cameras from images of a board", ""}};
// nullptr: not one of these commands.
const CommandProgram* FindCommandProgram(std::string_view command);

// Becomes the program of `program`, with `arguments` as its command line (the command first).
// Returns only if it fails: prints why, and returns the exit code.
int Become(const CommandProgram& program, char** arguments);

// The main function of a command. `footer` follows the options of --help, `add_options`
// declares them, `run` returns the exit code and may throw (see ExitCode).
int RunCommandProgram(int argc, char** argv, std::string_view command, const char* footer,
                      const std::function<void(CLI::App*)>& add_options,
                      const std::function<int(const std::stop_token&)>& run);
template <class Options>
int RunCommandProgram(int argc, char** argv, std::string_view command, const char* footer,
                      void (*add_options)(CLI::App*, Options*),
                      int (*run)(const Options&, const std::stop_token&)) {
  Options options;
  return RunCommandProgram(
      argc, argv, command, footer, [&](CLI::App* app) { add_options(app, &options); },
      [&](const std::stop_token& stop) { return run(options, stop); });
}

// Declares the positional argument `scene` and --override.
void AddSceneOptions(CLI::App* command, std::filesystem::path* scene,
                     std::vector<std::string>* overrides);

// nullopt: parsed. Otherwise prints help, version or the mistake, and returns the exit code.
std::optional<int> ParseCommandLine(CLI::App* app, int argc, char** argv);

}  // namespace palpate
