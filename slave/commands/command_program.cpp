#include "slave/commands/command_program.h"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

#include "shared/program/program.h"
#include "slave/commands/program.h"

namespace palpate {

const CommandProgram* FindCommandProgram(std::string_view command) {
  const auto* found = std::ranges::find(kCommandPrograms, command, &CommandProgram::command);
  return found == std::end(kCommandPrograms) ? nullptr : found;
}

int Become(const CommandProgram& program, char** arguments) {
  const std::string command(program.command);
  const std::filesystem::path file = FindPart(program.program);
  if (file.empty()) {
    const std::string install = *program.libraries == '\0' ? ""
                                                           : std::string("deploy/install.sh ") +
                                                                 program.libraries + ", then ";
    std::fprintf(
        stderr,
        "palpate-slave: %s needs %s, which is not installed next to this program. To build "
        "it: %sdeploy/build.sh release\n",
        command.c_str(), program.program, install.c_str());
    return kFailed;
  }
  execv(file.c_str(), arguments);
  std::perror(file.c_str());
  return kFailed;
}

int RunCommandProgram(int argc, char** argv, std::string_view command, const char* footer,
                      const std::function<void(CLI::App*)>& add_options,
                      const std::function<int(const std::stop_token&)>& run) {
  LogToStderr();
  StopOnSignal stop;
  stop.ExpectAnswer();
  CLI::App app{FindCommandProgram(command)->description, "palpate-slave " + std::string(command)};
  app.footer(footer);
  app.set_version_flag("--version", Version());
  add_options(&app);
  if (const auto code = ParseCommandLine(&app, argc, argv)) return *code;
  return ExitCode([&] { return run(stop.token()); });
}

void AddSceneOptions(CLI::App* command, std::filesystem::path* scene,
                     std::vector<std::string>* overrides) {
  command->add_option("scene", *scene, "Scene file (YAML)")->required();
  command->add_option("--override", *overrides,
                      "Replace a value of the scene: key.path=value (repeatable)");
}

std::optional<int> ParseCommandLine(CLI::App* app, int argc, char** argv) {
  try {
    app->parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app->exit(e) == 0 ? 0 : kUnusable;
  }
  return std::nullopt;
}

}  // namespace palpate
