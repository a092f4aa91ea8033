// palpate-slave: the command line.
#include <cstdio>
#include <string>
#include <string_view>

#include <unistd.h>

#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "slave/commands/commands.h"
#include "slave/commands/identify/identify.h"
#include "slave/commands/program.h"
#include "slave/commands/record/record.h"
#include "slave/commands/train/train.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave check deploy/scenes/silicone-block.yaml
  palpate-slave serve deploy/scenes/silicone-block.yaml --listen 127.0.0.1:50051
  palpate-slave serve deploy/scenes/silicone-block.yaml --override model.elements=60
  palpate-slave serve deploy/scenes/silicone-block.yaml --record slave.mcap
  palpate-slave process deploy/scenes/silicone-block.yaml --out build/press
  palpate-slave process slave.mcap --out build/again
  palpate-slave export slave.mcap --out build/slave
  palpate-slave solve deploy/scenes/silicone-block.yaml --contacts contacts.csv --out answers.csv
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --budget 60
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --materials --out build/cube
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --cloud cube.pcd --out build/cube
  palpate-slave train simulated --out build/fingertip
  palpate-slave identify compression=EF10.csv --diameter 50mm --height 30mm --ends bonded \
      --out build/ef10
  palpate-slave calibrate --left 'left*.jpg' --right 'right*.jpg' --board 9x6 --square 25mm \
      --out rig.yaml

Exit codes: 0 done, 1 ran and failed, 2 unusable arguments or scene.)";

void AddTrainOptions(CLI::App* command, TrainOptions* train) {
  command->footer(kTrainHelp);
  command->add_option("DATA", train->data, "Recordings, or `simulated`; see below")->required();
  command->add_option(
      "--network", train->networks,
      "One or more of rnn_21 (default), rnn_19, dnn_21, dnn_19, tnn_21, tnn_19; all "
      "(the first four); or localiser");
  command->add_option("--out", train->out, "Folder for network.json and training.csv")
      ->type_name("DIR")
      ->required();
  command->add_option("--test", train->test, "Test on these recordings, not on a fifth of DATA");
  command
      ->add_option("--from", train->from,
                   "Fit only the gain of this existing network, on the normal force fz")
      ->type_name("PATH");
  command->add_option("--finger", train->finger,
                      "Finger to use from a recording with several fingers");
  command
      ->add_option("--rest", train->rest,
                   "Number of first samples, without contact, whose mean is the baseline")
      ->capture_default_str();
  command->add_option("--optimiser", train->optimiser, "adam, or sgd as in paper B")
      ->capture_default_str();
  command
      ->add_option("--rate", train->rate,
                   "Learning rate; 0 selects 0.004 for adam and 0.01 for sgd")
      ->capture_default_str();
  command->add_option("--epochs", train->epochs, "Largest number of epochs")->capture_default_str();
  command
      ->add_option("--patience", train->patience,
                   "Stop after this many epochs without a lower validation error")
      ->capture_default_str();
  command->add_option("--batch", train->batch, "Windows per optimiser step")->capture_default_str();
  command->add_option("--seed", train->seed, "Random seed; the same seed gives the same weights")
      ->capture_default_str();
  command
      ->add_option("--threads", train->threads, "Number of threads; it does not change the result")
      ->capture_default_str();
  command->add_option("--presses", train->presses, "Number of contacts that `simulated` makes")
      ->capture_default_str();
  command
      ->add_option("--electrodes", train->electrodes,
                   "Required for localiser: file with rows NAME,x,y,z,nx,ny,nz in mm, or simulated")
      ->type_name("FILE");
  command->add_option("--contact-pdc", train->contact_pdc,
                      "For localiser: pressure pdc above which a sample is in contact [counts]; "
                      "default: estimated from the data");
  command
      ->add_option("--normals", train->normals,
                   "For localiser: axes of nx,ny,nz in the fingertip frame, for example -x,y,-z; "
                   "auto estimates them")
      ->capture_default_str();
}

void AddIdentifyOptions(CLI::App* command, IdentifyOptions* identify) {
  command->footer(kIdentifyHelp);
  command->add_option("DATA", identify->data, "Tables of tests; see below")->required();
  command->add_option("--out", identify->out, "Folder for report.json and identify.svg")
      ->type_name("DIR")
      ->required();
  command->add_option("--diameter", identify->diameter,
                      "Diameter of a cylindrical specimen, for example 50mm");
  command->add_option("--area", identify->area,
                      "Area of the loaded cross-section, for example 400mm2");
  command->add_option("--height", identify->height,
                      "Height of the specimen at rest, or its gauge length");
  command
      ->add_option("--ends", identify->ends,
                   "free, or bonded for a cylinder whose ends adhere to plates")
      ->capture_default_str();
  command->add_option("--poisson", identify->poisson_ratio, "Poisson's ratio, used for bonded ends")
      ->check(CLI::Range(-0.9, 0.5))
      ->capture_default_str();
  command->add_option("--stress-unit", identify->stress_unit,
                      "Unit of stress columns whose header names none; default: Pa");
  command->add_option("--x", identify->x, "Name of the deformation column");
  command->add_option("--y", identify->y, "Name of the load column");
  command->add_option("--from", identify->from, "Use rows whose absolute strain is at least this");
  command->add_option("--to", identify->to, "Use rows whose absolute strain is at most this");
  command->add_flag("--foam", identify->foam,
                    "Fit compressible constitutive models instead of incompressible ones");
  command->add_option("--scene", identify->scene, "For press and pictures: scene file (YAML)")
      ->type_name("FILE");
  command->add_option("--override", identify->overrides,
                      "For press and pictures: replace a value of the scene, key.path=value");
  command
      ->add_option("--width", identify->width, "For press: contact width of rows without one [m]")
      ->check(CLI::Range(0.0, 1e3));
  command->add_flag("--fit-poisson", identify->fit_poisson,
                    "For press: estimate Poisson's ratio as well");
}

// Commands that are programs of their own: what they load, no other command needs.
struct Part {
  const char* command;
  const char* description;
  const char* needs;
};
constexpr Part kParts[] = {
    {"evaluate", "Compare the estimated shape with a measured point cloud",
     "the Point Cloud Library's headers are installed (deploy/install.sh clouds)"},
    {"calibrate", "Calibrate lens, stereo rig and pose of cameras from images of a board",
     "OpenCV's calib3d is installed (deploy/install.sh calibration)"},
};

// Becomes the program of `part`, given what stands behind the command. Returns only if it fails.
int Become(const Part& part, char** arguments) {
  const std::string name = std::string("palpate-") + part.command;
  const auto program = FindPart(name);
  if (program.empty()) {
    std::fprintf(stderr,
                 "palpate-slave: %s needs %s, which is not installed next to this program. The "
                 "build makes it where %s\n",
                 part.command, name.c_str(), part.needs);
    return kFailed;
  }
  execv(program.c_str(), arguments);
  std::perror(program.c_str());
  return kFailed;
}

int Main(int argc, char** argv) {
  for (const Part& part : kParts) {
    if (argc > 1 && std::string_view(argv[1]) == part.command) return Become(part, argv + 1);
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
    command->add_option("scene", options->scene, "Scene file (YAML)")->required();
    command->add_option("--override", options->overrides,
                        "Replace a value of the scene: key.path=value (repeatable)");
    return command;
  };

  ServeOptions serve;
  auto* serve_command = add_command(
      "serve", "Observe the object and stream the estimated force over gRPC until stopped", &serve);
  serve_command
      ->add_option("--listen", serve.listen, "Address to serve; port 0 selects any free port")
      ->type_name("HOST:PORT")
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

  serve_command
      ->add_option("--metrics", serve.metrics, "Address that serves Prometheus metrics at /metrics")
      ->type_name("HOST:PORT");
  serve_command
      ->add_option("--record", serve.record,
                   "Record every sample and estimate without loss to this .mcap file; `process "
                   "FILE.mcap` recomputes the estimates")
      ->type_name("FILE");
  serve_command
      ->add_option("--record-limit", serve.record_limit,
                   "Total size of the recording's files at which recording ends")
      ->capture_default_str();
  serve_command
      ->add_option("--record-part", serve.record_part,
                   "Begin a new file after this many seconds: FILE-0001.mcap, FILE-0002.mcap; "
                   "`process FILE.mcap` and `export FILE.mcap` join them")
      ->check(CLI::Range(1.0, 1e6));

  ProcessOptions process;
  auto* process_command = add_command(
      "process", "Process recorded images, or a recording (FILE.mcap), as fast as possible",
      &process);
  process_command->add_option("--out", process.out, "Folder for states.csv and summary.json")
      ->type_name("DIR")
      ->required();
  process_command->add_flag("--pictures", process.pictures,
                            "Also write every image with the detections drawn in");
  process_command->add_flag("--frames", process.frames,
                            "Also write every source image, to be processed again");
  process_command->add_flag("--points", process.points,
                            "Also write points.csv: points tracked by a stereo pair or depth "
                            "camera, with sigma and disparity");
  process_command
      ->add_option(
          "--duration", process.duration,
          "Seconds of a simulated target's path; files and scripted contacts end on their own")
      ->type_name("FLOAT:s");

  RecordingExport exported;
  CLI::App* export_command = app.add_subcommand(
      "export", "Convert a recording to NumPy arrays, images and the files of its scene");
  export_command
      ->add_option("file", exported.file, "Recording that `serve --record` wrote (FILE.mcap)")
      ->type_name("FILE")
      ->required();
  export_command->add_option("--out", exported.out, "Folder, created if missing")
      ->type_name("DIR")
      ->required();

  SolveOptions solve;
  auto* solve_command =
      add_command("solve", "Run the model alone on the contacts and loads of CSV files", &solve);
  solve_command
      ->add_option("--contacts", solve.contacts,
                   "CSV case,x,y,z,dx,dy,dz[,width][,t]; planar scenes need no z")
      ->type_name("FILE");
  solve_command
      ->add_option("--loads", solve.loads,
                   "CSV case,x,y,z,fx,fy,fz[,width][,t]; t gives a load history for time: dynamic")
      ->type_name("FILE");
  solve_command->add_option("--out", solve.out, "CSV with one row per input row")
      ->type_name("FILE")
      ->required();
  solve_command->add_option("--field", solve.field, "VTU file of the deformed body")
      ->type_name("FILE");

  CheckOptions check;
  add_command("check", "Report what will run and why, and the expected rate and error", &check);

  StudyOptions study;
  auto* study_command =
      add_command("study", "Measure speed and accuracy of every model that fits the scene", &study);
  study_command->add_option("--out", study.out, "Folder for study.csv, study.json and study.svg")
      ->type_name("DIR")
      ->required();
  study_command->add_option("--budget", study.budget, "Time limit for all models together")
      ->type_name("FLOAT:s")
      ->capture_default_str();
  study_command->add_flag("--end-to-end", study.end_to_end,
                          "Measure instead what each stage adds to the error of the rendered "
                          "force");
  study_command->add_option("--delay", study.delay, "Delay of the link for --end-to-end")
      ->type_name("FLOAT:s")
      ->capture_default_str();

  TrainOptions train;
  CLI::App* train_command =
      app.add_subcommand("train", "Train a fingertip's force network or its localiser");
  AddTrainOptions(train_command, &train);

  IdentifyOptions identify;
  CLI::App* identify_command =
      app.add_subcommand("identify", "Identify material constants from tables of tests");
  AddIdentifyOptions(identify_command, &identify);

  for (const Part& part : kParts) app.add_subcommand(part.command, part.description);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : kUnusable;
  }
  return ExitCode([&] {
    if (serve_command->parsed()) {
      LogWithoutWaiting();
      RaiseDescriptorLimit();
      if (!serve.record.empty()) stop.LetRecordingEnd();
      return RunServe(serve, stop);
    }
    stop.ExpectAnswer();
    if (process_command->parsed()) return RunProcess(process, stop.token());
    if (export_command->parsed()) return RunExportRecording(exported, stop.token());
    if (solve_command->parsed()) return RunSolve(solve, stop.token());
    if (study_command->parsed()) return RunStudyCommand(study, stop.token());
    if (train_command->parsed()) return RunTrain(train, stop.token());
    if (identify_command->parsed()) return RunIdentify(identify, stop.token());
    return RunCheck(check);
  });
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
