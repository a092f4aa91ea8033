// palpate-slave: the command line.
#include <iostream>

#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "slave/commands/check/check.h"
#include "slave/commands/command_program.h"
#include "slave/commands/health/health.h"
#include "slave/commands/process/process.h"
#include "slave/commands/program.h"
#include "slave/commands/serve/serve.h"
#include "slave/commands/solve/solve.h"
#include "slave/scene/keys.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave check deploy/scenes/silicone-block.yaml
  palpate-slave serve deploy/scenes/silicone-block.yaml --listen 127.0.0.1:50051
  palpate-slave serve deploy/scenes/silicone-block.yaml --override model.elements=60
  palpate-slave serve deploy/scenes/silicone-block.yaml --record slave.mcap
  palpate-slave serve --setup my-scene --camera 0
  palpate-slave serve deploy/scenes/silicone-block.yaml --publish nats://127.0.0.1:4222
  palpate-slave health 127.0.0.1:50051
  palpate-slave process deploy/scenes/silicone-block.yaml --out build/press
  palpate-slave process slave.mcap --out build/again
  palpate-slave solve deploy/scenes/silicone-block.yaml --contacts contacts.csv --out answers.csv
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --budget 60
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --cloud cube.pcd --out build/cube
  palpate-slave identify compression=EF10.csv --diameter 50mm --height 30mm --ends bonded \
      --out build/ef10
  palpate-slave calibrate --left 'left*.jpg' --right 'right*.jpg' --board 9x6 --square 25mm \
      --out rig.yaml
  palpate-slave verify deploy/scenes/silicone-block.yaml --sensor --out build/card

Exit codes: 0 done, 1 ran and failed, 2 unusable arguments or scene.)";

int Main(int argc, char** argv) {
  if (const auto* program = argc > 1 ? FindCommandProgram(argv[1]) : nullptr) {
    return Become(*program, argv + 1);
  }
  LogToStderr();
  StopOnSignal stop;

  CLI::App app{
      "Palpate's slave: observes a soft object, estimates the contact force and streams it."};
  app.footer(kExamples);
  app.require_subcommand(1);
  app.set_version_flag("--version", Version());

  const auto add_command = [&](const char* name, const char* about, auto* options) {
    CLI::App* command = app.add_subcommand(name, about);
    AddSceneOptions(command, &options->scene, &options->overrides);
    return command;
  };

  ServeOptions serve;
  auto* serve_command = add_command(
      "serve", "Observe the object and stream the estimated force over gRPC until stopped", &serve);
  serve_command->get_option("scene")->required(false);
  Add(serve_command, "--setup", &serve.setup, "DIR",
      "Folder of scenes that a client sets up on the images of --camera: begins with the last one, "
      "or without a scene");
  Add(serve_command, "--camera", &serve.camera, "N|FILE|URL",
      "Camera of --setup: a number, image files or a video (repeated), an address or a GStreamer "
      "pipeline")
      ->capture_default_str()
      ->needs("--setup");
  serve_command->add_option("--camera-rate", serve.camera_rate, "Images per second of --camera")
      ->check(CLI::Range(0.1, 1e4))
      ->capture_default_str()
      ->needs("--setup");
  Add(serve_command, "--listen", &serve.listen, "HOST:PORT",
      "Address to serve; port 0 selects any free port")
      ->capture_default_str();
  serve_command->add_flag("--insecure", serve.insecure,
                          "Allow addresses that are not loopback, in plain text");
  serve_command
      ->add_option("--tls", serve.tls,
                   "Mutual TLS 1.3: folder with ca.pem, cert.pem and key.pem (deploy/certs)")
      ->check(CLI::ExistingDirectory);
  serve_command
      ->add_option("--state-dir", serve.state_dir,
                   "Folder that keeps an emergency stop across restarts")
      ->envname("STATE_DIRECTORY")
      ->check(CLI::ExistingDirectory);

  Add(serve_command, "--publish", &serve.publish, "URL",
      "NATS server, nats://HOST:PORT or tls://HOST:PORT, that passes states, meshes and images on "
      "to any number of observers");
  Add(serve_command, "--record", &serve.record, "FILE",
      "Record every sample and estimate without loss to this .mcap file, or to FILE-2.mcap, ... "
      "if it exists; `process FILE.mcap` recomputes the estimates");
  AddShown(serve_command, "--record-limit", &serve.record_limit,
           "Total size of the recording's files at which recording ends");
  serve_command
      ->add_option("--record-part", serve.record_part,
                   "Begin a new file after this many seconds: FILE-0001.mcap, FILE-0002.mcap; "
                   "`process FILE.mcap` joins them")
      ->check(CLI::Range(1.0, 1e6));

  ProcessOptions process;
  auto* process_command = add_command(
      "process", "Process recorded images, or a recording (FILE.mcap), as fast as possible",
      &process);
  Add(process_command, "--out", &process.out, "DIR", "Folder for states.csv and summary.json")
      ->required();
  process_command->add_flag("--images", process.images,
                            "Also write every image with the detections drawn in");
  process_command->add_flag("--frames", process.frames,
                            "Also write every source image, to be processed again");
  process_command->add_flag("--points", process.points,
                            "Also write points.csv: points tracked by a stereo pair or depth "
                            "camera, with sigma and disparity");
  Add(process_command, "--duration", &process.duration, "FLOAT:s",
      "Seconds of a simulated target's path; files and scripted contacts end on their own");

  SolveOptions solve;
  auto* solve_command =
      add_command("solve", "Run the model alone on the contacts and loads of CSV files", &solve);
  Add(solve_command, "--contacts", &solve.contacts, "FILE",
      "CSV case,x,y,z,dx,dy,dz[,width][,depth][,radius][,t]; rows of one case act together; planar "
      "scenes need no z");
  CLI::Option* independent =
      solve_command->add_flag("--independent", solve.independent,
                              "Each row acts alone, also where rows have the same case");
  solve_command
      ->add_flag("--path", solve.follows_path,
                 "Each case continues from the one before, such as press, drag and lift under "
                 "friction; else each starts from rest")
      ->excludes(independent);
  Add(solve_command, "--loads", &solve.loads, "FILE",
      "CSV case,x,y,z,fx,fy,fz[,width][,t]; t gives a load history for time: dynamic");
  Add(solve_command, "--out", &solve.out, "FILE", "CSV with one row per input row")->required();
  Add(solve_command, "--field", &solve.field, "FILE", "VTU file of the deformed body");
  solve_command->add_flag("--moments", solve.moments,
                          "Also write mx,my,mz: moment of the force about the displaced centre of "
                          "the contact, empty where it is unknown");

  CLI::App* keys_command =
      app.add_subcommand("keys", "Print the reference of the keys of a scene (Markdown)");

  CheckOptions check;
  add_command("check", "Report what will run and why, and the expected rate and error", &check);

  HealthOptions health;
  CLI::App* health_command =
      app.add_subcommand("health", "Ask a running slave whether it serves and senses");
  Add(health_command, "target", &health.target, "HOST:PORT", "Address of the slave")
      ->capture_default_str();
  Add(health_command, "--tls", &health.tls, "DIR",
      "Use mutual TLS 1.3 with ca.pem, cert.pem and key.pem of this folder (deploy/certs)")
      ->check(CLI::Validator(CLI::ExistingDirectory).description(""));
  health_command->add_flag(
      "--insecure", health.insecure,
      "Allow plain text to other machines; without it only loopback is accepted");
  health_command->add_option("--wait", health.wait, "Time limit for the answer, in seconds")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();

  for (const CommandProgram& program : kCommandPrograms) {
    app.add_subcommand(std::string(program.command), program.description);
  }

  if (const auto code = ParseCommandLine(&app, argc, argv)) return *code;
  return ExitCode([&] {
    if (serve_command->parsed()) {
      LogWithoutWaiting();
      RaiseDescriptorLimit();
      if (!serve.record.empty()) stop.LetRecordingEnd();
      return RunServe(serve, stop);
    }
    stop.ExpectAnswer();
    if (process_command->parsed()) return RunProcess(process, stop.token());
    if (solve_command->parsed()) return RunSolve(solve, stop.token());
    if (health_command->parsed()) return RunHealth(health);
    if (keys_command->parsed()) {
      std::cout << SceneKeysPage();
      return 0;
    }
    return RunCheck(check);
  });
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
