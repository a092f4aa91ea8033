// palpate-simulator: the command line.
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <spdlog/spdlog.h>

#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "slave/commands/command_program.h"
#include "slave/commands/program.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/presses/write_presses.h"
#include "slave/simulator/program/recorder.h"
#include "slave/simulator/program/streaming.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-simulator deploy/scenes/silicone-block.yaml --slave 127.0.0.1:50051
  palpate-simulator deploy/scenes/foam-cube.yaml --record build/cube
  palpate-simulator presses --out build/presses

Exit codes: 0 done, 1 ran and failed, 2 unusable arguments or scene.)";

struct Options {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  StreamingTarget slave;
  RecordOptions record;
};

void AddOptions(CLI::App* app, Options* options) {
  AddSceneOptions(app, &options->scene, &options->overrides);
  app->get_option("scene")->required(false);  // of the simulation; `presses` needs none
  auto* const slave =
      Add(app, "--slave", &options->slave.address, "HOST:PORT",
          "Slave that takes the samples and moves the tool, in real time; or --record");
  Add(app, "--record", &options->record.folder, "DIR",
      "Folder for the samples of a scripted press, as fast as they are computed; -: standard "
      "output")
      ->excludes(slave);
  app->add_option(
         "--tls", options->slave.tls,
         "Mutual TLS 1.3 with the slave: folder with folders sensor and arm, each with ca.pem, "
         "cert.pem and key.pem")
      ->check(CLI::ExistingDirectory);
  app->add_option("--duration", options->record.duration,
                  "Recorded seconds of a simulated target's path")
      ->check(CLI::Range(0.0, 86400.0));
  app->add_option("--presses", options->record.presses, "Recorded contacts of simulated fingertips")
      ->check(CLI::Range(1, 1000));
  app->add_flag("--surface", options->record.surface,
                "Record the true surface of the object that fingertips touch as well");
}

CLI::App* AddPresses(CLI::App* app, PressesOptions* options) {
  CLI::App* const presses = app->add_subcommand(
      "presses", "Write contacts of the simulated fingertip, from which palpate.train learns");
  presses->footer(R"(Example:
  palpate-simulator presses --out build/presses
  python3 -m palpate.train build/presses --network all --out build/fingertip)");
  Add(presses, "--out", &options->out, "DIR", "Folder for the CSV files, one per start")
      ->required();
  AddShown(presses, "--presses", &options->presses, "Number of contacts");
  AddShown(presses, "--seed", &options->seed, "Random seed; the same seed gives the same contacts");
  return presses;
}

int Run(const Options& options, const std::stop_token& stop) {
  if (options.scene.empty()) throw std::invalid_argument("expected SCENE, or presses");
  if (options.slave.address.empty() && options.record.folder.empty()) {
    throw std::invalid_argument("--slave, --record: expected one of them");
  }
  const Scene scene = LoadScene(options.scene, options.overrides);
  const auto environment = MakeSimulatedEnvironment(scene);
  if (!environment) {
    throw std::invalid_argument(options.scene.string() + ": no `source: simulated` in its sensing");
  }
  if (options.record.folder.empty()) {
    StreamTo(options.slave, scene, *environment, stop);
  } else {
    Record(scene, *environment, options.record, stop);
  }
  return 0;
}

int Main(int argc, char** argv) {
  LogToStderr();
  StopOnSignal stop;
  CLI::App app{"Palpate's simulator: object, sensors and manipulator of a scene",
               "palpate-simulator"};
  app.footer(kExamples);
  app.set_version_flag("--version", Version());
  Options options;
  AddOptions(&app, &options);
  PressesOptions presses;
  const CLI::App* const presses_command = AddPresses(&app, &presses);
  if (const auto code = ParseCommandLine(&app, argc, argv)) return *code;
  if (presses_command->parsed() || !options.record.folder.empty()) stop.ExpectAnswer();
  return ExitCode(
      [&] {
        return presses_command->parsed() ? WritePresses(presses, stop.token())
                                         : Run(options, stop.token());
      },
      "palpate-simulator");
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
