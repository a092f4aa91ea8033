// palpate-slave: the command line.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <thread>

#include <CLI/CLI.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "slave/commands/calibrate/calibrate.h"
#include "slave/commands/check/check.h"
#include "slave/commands/evaluate/evaluate.h"
#include "slave/commands/process.h"
#include "slave/commands/serve.h"
#include "slave/commands/solve/solve.h"
#include "slave/commands/study.h"
#include "slave/commands/train/train.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

constexpr int kFailed = 1, kUnusable = 2;

constexpr const char* kExamples = R"(Examples:
  palpate-slave check deploy/scenes/silicone-block.yaml
  palpate-slave serve deploy/scenes/silicone-block.yaml --listen 127.0.0.1:50051
  palpate-slave serve deploy/scenes/silicone-block.yaml --override model.elements=60
  palpate-slave process deploy/scenes/silicone-block.yaml --out build/press
  palpate-slave solve deploy/scenes/silicone-block.yaml --contacts contacts.csv --out answers.csv
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --budget 60
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --materials --out build/cube
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --cloud cube.pcd --out build/cube
  palpate-slave train simulated --out build/fingertip
  palpate-slave calibrate --left 'left*.jpg' --right 'right*.jpg' --board 9x6 --square 25mm \
      --out rig.yaml

Exit codes: 0 done, 1 ran and failed, 2 unusable arguments or scene.)";

// For a command to end by itself after a signal; what computes for longer, a large model say, hears
// nothing, moves nothing and has every row it wrote flushed.
constexpr std::chrono::seconds kPatience(2);

// SIGINT and SIGTERM request a stop. They are blocked everywhere and taken by one thread, so that
// no other call is ever interrupted. Block before any thread starts.
class StopOnSignal {
 public:
  StopOnSignal() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    waiter_ = std::jthread([this](const std::stop_token& end) {
      const timespec pause{0, 50'000'000};
      std::optional<std::chrono::steady_clock::time_point> last_call;
      while (!end.stop_requested()) {
        const auto now = std::chrono::steady_clock::now();
        if (sigtimedwait(&signals_, nullptr, &pause) > 0 && !last_call) {
          source_.request_stop();
          last_call = now + kPatience;
        }
        if (last_call && now > *last_call) {
          if (exit_code_ != 0) std::fputs("stopped before it was done\n", stderr);
          std::_Exit(exit_code_);
        }
      }
    });
  }
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }
  // What is ended before it has answered has failed; a service that is ended has not.
  void ExpectAnswer() { exit_code_ = kFailed; }

 private:
  std::atomic<int> exit_code_ = 0;
  sigset_t signals_{};
  std::stop_source source_;
  std::jthread waiter_;
};

void AddEvaluateOptions(CLI::App* command, EvaluateOptions* options) {
  command->add_option("--cloud", options->cloud,
                      "Measured points in the frame of sense.depth_camera (PCD); without, a "
                      "simulated hand presses the object and a virtual camera measures it");
  command->add_option("--out", options->out, "Folder for report.html, report.json and clouds")
      ->required();
  command->add_option(
      "--contacts", options->contacts,
      "What deforms the object: CSV as for solve; without, what the scene's tactile "
      "recording tells at its end, or nothing");
  command->add_option("--loads", options->loads, "The same with forces");
  command
      ->add_option("--segment", options->segment,
                   "surfaces: by colour and shape; colour: by colour alone; no: all is the object")
      ->capture_default_str();
  command->add_option("--at", options->at, "A point on the object, x,y,z [m], frame of the cloud")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--colour", options->colour, "Colour of the object, red,green,blue")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--voxel", options->voxel, "Cells of the cloud thinned out [m]; 0: by itself")
      ->capture_default_str();
  command->add_option("--neighbours", options->neighbours, "Of a point that grows by colour")
      ->capture_default_str();
  command->add_option("--point-colour", options->point_colour, "Within a region, 0 to 442")
      ->capture_default_str();
  command->add_option("--region-colour", options->region_colour, "Regions less different unite")
      ->capture_default_str();
  command->add_option("--repetitions", options->repetitions, "Presses of the simulated hand")
      ->capture_default_str();
  command->add_flag("--materials", options->materials,
                    "The simulated object in each of paper B's three foams");
  command->add_option("--leaf", options->leaf, "Edge of the octree's leaves [m]")
      ->capture_default_str();
}

void AddTrainOptions(CLI::App* command, TrainOptions* train) {
  command->footer(kTrainHelp);
  command->add_option("DATA", train->data, "Recordings or simulated, see below")->required();
  command->add_option("--network", train->networks,
                      "rnn_21 (default), rnn_19, dnn_21, dnn_19, several, all; or localiser");
  command->add_option("--out", train->out, "Folder for network.json and training.csv")->required();
  command->add_option("--test", train->test, "Recordings to test on instead of a fifth of DATA");
  command->add_option("--from", train->from, "Known network: only its gain is fitted, on fz");
  command->add_option("--finger", train->finger, "Finger of recordings with several");
  command->add_option("--rest", train->rest, "First samples whose mean is the rest value")
      ->capture_default_str();
  command->add_option("--optimiser", train->optimiser, "adam, or sgd as in the paper")
      ->capture_default_str();
  command->add_option("--rate", train->rate, "Learning rate; 0: 0.004 for adam, 0.01 for sgd")
      ->capture_default_str();
  command->add_option("--epochs", train->epochs, "At most")->capture_default_str();
  command
      ->add_option("--patience", train->patience,
                   "Epochs without a better validation before it stops")
      ->capture_default_str();
  command->add_option("--batch", train->batch, "Windows per step")->capture_default_str();
  command->add_option("--seed", train->seed, "Same seed, same weights")->capture_default_str();
  command->add_option("--threads", train->threads, "Do not change the result")
      ->capture_default_str();
  command->add_option("--presses", train->presses, "Of `simulated`")->capture_default_str();
  command->add_option("--electrodes", train->electrodes,
                      "localiser, wanted: layout NAME,x,y,z,nx,ny,nz in mm, or simulated");
  command->add_option("--contact-pdc", train->contact_pdc,
                      "localiser: contact is above it; default: found by itself");
  command
      ->add_option("--normals", train->normals,
                   "localiser: nx,ny,nz in the fingertip's frame, -x,y,-z say; auto: found")
      ->capture_default_str();
}

void AddCalibrateOptions(CLI::App* command, CalibrateOptions* calibrate) {
  command->footer(kCalibrateHelp);
  command->add_option("--left", calibrate->left, "Pictures of the left, or the only, camera");
  command->add_option("--right", calibrate->right, "Pictures of the right camera");
  command->add_option("--board", calibrate->board, "Inner corners or circles, 9x6 say");
  command->add_option("--square", calibrate->square, "Between neighbours, 25mm say");
  command->add_option("--pattern", calibrate->pattern, "chessboard, circles or asymmetric-circles")
      ->capture_default_str();
  command->add_option("--distance", calibrate->distance,
                      "Of a plane, 250mm say: prints what a pixel shows there");
  command->add_option("--out", calibrate->out, "File of the rig, or of the lens of one camera");
  command->add_option("--drawing", calibrate->drawing, "SVG of boards, coverage and residuals");
  command->add_flag("--force", calibrate->force,
                    "Write also what cannot be trusted; still exits 1");
  command->add_option("--register", calibrate->tip_places,
                      "CSV x,y,z,u,v[,u_right,v_right] of the tip: the camera's pose for a scene");
  command->add_option("--rig", calibrate->rig, "For --register: a rig or lens known already");
  command->add_option("--size", calibrate->size,
                      "For --register: a camera straight above z = 0, 640x480 say");
  command->add_option("unquoted", calibrate->unquoted)->group("");
  command->add_flag("--plane", calibrate->plane,
                    "For --register: the camera of the lens looks straight down on z = 0");
}

int Main(int argc, char** argv) {
  // Standard output belongs to the answers; the log goes beside it.
  spdlog::set_default_logger(spdlog::stderr_color_mt("palpate"));
  spdlog::set_pattern("%^%l%$ %v");
  StopOnSignal stop;

  CLI::App app{"Palpate's slave: watches a soft object, computes the contact force, streams it."};
  app.footer(kExamples);
  app.require_subcommand(1);
  app.set_version_flag("--version", PALPATE_VERSION);

  const auto add_scene = [](CLI::App* command, std::filesystem::path* scene,
                            std::vector<std::string>* overrides) {
    command->add_option("scene", *scene, "Scene file (YAML)")->required();
    command->add_option("--override", *overrides, "Replace a value: key.path=value (repeatable)");
  };

  ServeOptions serve;
  CLI::App* serve_command = app.add_subcommand("serve", "Watch and answer over gRPC until stopped");
  add_scene(serve_command, &serve.scene, &serve.overrides);
  serve_command->add_option("--listen", serve.listen, "HOST:PORT; port 0: any free one")
      ->capture_default_str();
  serve_command->add_flag("--insecure", serve.insecure,
                          "Serve addresses that are not loopback, in plain text");

  ProcessOptions process;
  CLI::App* process_command =
      app.add_subcommand("process", "Run over recorded pictures as fast as they go");
  add_scene(process_command, &process.scene, &process.overrides);
  process_command->add_option("--out", process.out, "Folder for states.csv and summary.json")
      ->required();
  process_command->add_flag("--pictures", process.pictures,
                            "Also write every picture with what was seen drawn in");
  process_command->add_flag("--frames", process.frames,
                            "Also write every picture as it came: a recording to process again");
  process_command->add_option("--duration", process.duration,
                              "Seconds of a simulated target's path; files and scripted presses "
                              "end by themselves");

  SolveOptions solve;
  CLI::App* solve_command = app.add_subcommand("solve", "Run the model alone on rows of a file");
  add_scene(solve_command, &solve.scene, &solve.overrides);
  solve_command->add_option("--contacts", solve.contacts,
                            "CSV case,x,y,z,dx,dy,dz[,width][,t]; planar scenes need no z");
  solve_command->add_option("--loads", solve.loads,
                            "CSV case,x,y,z,fx,fy,fz[,width][,t]; t: a history for time: dynamic");
  solve_command->add_option("--out", solve.out, "CSV with one row per input row")->required();
  solve_command->add_option("--field", solve.field, "VTU of the deformed body");

  CheckOptions check;
  CLI::App* check_command = app.add_subcommand("check", "Say what will run and why");
  add_scene(check_command, &check.scene, &check.overrides);

  StudyOptions study;
  CLI::App* study_command = app.add_subcommand(
      "study", "Measure speed against accuracy of every model that fits the scene");
  add_scene(study_command, &study.scene, &study.overrides);
  study_command->add_option("--out", study.out, "Folder for study.csv, study.json and study.svg")
      ->required();
  study_command->add_option("--budget", study.budget, "Seconds for all models together")
      ->capture_default_str();

  EvaluateOptions evaluate;
  CLI::App* evaluate_command =
      app.add_subcommand("evaluate", "Score the estimated shape against a measured cloud");
  add_scene(evaluate_command, &evaluate.scene, &evaluate.overrides);
  AddEvaluateOptions(evaluate_command, &evaluate);

  TrainOptions train;
  CLI::App* train_command =
      app.add_subcommand("train", "Learn a fingertip's force network or localiser");
  AddTrainOptions(train_command, &train);

  CalibrateOptions calibrate;
  CLI::App* calibrate_command =
      app.add_subcommand("calibrate", "Lens, rig and pose of cameras, from pictures of a board");
  AddCalibrateOptions(calibrate_command, &calibrate);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : kUnusable;
  }
  try {
    if (serve_command->parsed()) return RunServe(serve, stop.token());
    stop.ExpectAnswer();
    if (process_command->parsed()) return RunProcess(process, stop.token());
    if (solve_command->parsed()) return RunSolve(solve, stop.token());
    if (study_command->parsed()) return RunStudyCommand(study, stop.token());
    if (evaluate_command->parsed()) return RunEvaluate(evaluate, stop.token());
    if (train_command->parsed()) return RunTrain(train, stop.token());
    if (calibrate_command->parsed()) return RunCalibrate(calibrate, stop.token());
    return RunCheck(check);
  } catch (const SceneError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return kUnusable;
  } catch (const std::invalid_argument& e) {
    std::fprintf(stderr, "palpate-slave: %s\n", e.what());
    return kUnusable;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "palpate-slave: %s\n", e.what());
    return kFailed;
  }
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
