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
  command->add_option("DATA", train->data, "Recordings or simulated, see below")->required();
  command->add_option("--network", train->networks,
                      "rnn_21 (default), rnn_19, dnn_21, dnn_19 (all: these four), tnn_21, tnn_19, "
                      "several; or localiser");
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

void AddIdentifyOptions(CLI::App* command, IdentifyOptions* identify) {
  command->footer(kIdentifyHelp);
  command->add_option("DATA", identify->data, "Tables, see below")->required();
  command->add_option("--out", identify->out, "Folder for report.json and identify.svg")
      ->required();
  command->add_option("--diameter", identify->diameter, "Of a cylinder, 50mm say");
  command->add_option("--area", identify->area, "Of the loaded section, 400mm2 say");
  command->add_option("--height", identify->height, "Between the ends, or gauge length");
  command->add_option("--ends", identify->ends, "free, or bonded: of a cylinder between plates")
      ->capture_default_str();
  command->add_option("--poisson", identify->poisson_ratio, "For bonded ends")
      ->check(CLI::Range(-0.9, 0.5))
      ->capture_default_str();
  command->add_option("--stress-unit", identify->stress_unit, "Of columns that name none");
  command->add_option("--x", identify->x, "Column of the deformation");
  command->add_option("--y", identify->y, "Column of the load");
  command->add_option("--from", identify->from, "Least size of strain that is used");
  command->add_option("--to", identify->to, "Largest size of strain that is used");
  command->add_flag("--foam", identify->foam, "Compressible laws instead of incompressible ones");
  command->add_option("--scene", identify->scene, "press, pictures: the scene");
  command->add_option("--override", identify->overrides,
                      "press, pictures: key.path=value of the scene");
  command->add_option("--width", identify->width, "press: of rows that have none [m]")
      ->check(CLI::Range(0.0, 1e3));
  command->add_flag("--fit-poisson", identify->fit_poisson, "press: seek nu too");
}

// Commands that are programs of their own: what they load, no other command needs.
struct Part {
  const char* command;
  const char* description;
  const char* needs;
};
constexpr Part kParts[] = {
    {"evaluate", "Score the estimated shape against a measured cloud",
     "the Point Cloud Library's headers are (deploy/install.sh clouds)"},
    {"calibrate", "Lens, rig and pose of cameras, from pictures of a board",
     "OpenCV's calib3d is (deploy/install.sh calibration)"},
};

// Becomes the program of `part`, given what stands behind the command. Returns only if it fails.
int Become(const Part& part, char** arguments) {
  const std::string name = std::string("palpate-") + part.command;
  const auto program = FindPart(name);
  if (program.empty()) {
    std::fprintf(stderr,
                 "palpate-slave: %s is done by %s, which is not installed beside this program: it "
                 "is built where %s\n",
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

  CLI::App app{"Palpate's slave: watches a soft object, computes the contact force, streams it."};
  app.footer(kExamples);
  app.require_subcommand(1);
  app.set_version_flag("--version", Version());

  const auto add_command = [&](const char* name, const char* about, auto* options) {
    CLI::App* command = app.add_subcommand(name, about);
    command->add_option("scene", options->scene, "Scene file (YAML)")->required();
    command->add_option("--override", options->overrides,
                        "Replace a value: key.path=value (repeatable)");
    return command;
  };

  ServeOptions serve;
  auto* serve_command = add_command("serve", "Watch and answer over gRPC until stopped", &serve);
  serve_command->add_option("--listen", serve.listen, "HOST:PORT; port 0: any free one")
      ->capture_default_str();
  serve_command->add_flag("--insecure", serve.insecure,
                          "Serve addresses that are not loopback, in plain text");
  serve_command
      ->add_option("--tls", serve.tls,
                   "Mutual TLS 1.3: folder with ca.pem, cert.pem, key.pem (deploy/certs)")
      ->check(CLI::ExistingDirectory);
  serve_command
      ->add_option("--state-dir", serve.state_dir,
                   "Folder in which an emergency stop outlives the process")
      ->envname("STATE_DIRECTORY")
      ->check(CLI::ExistingDirectory);

  serve_command->add_option("--metrics", serve.metrics,
                            "HOST:PORT: health in numbers for Prometheus, at /metrics");
  serve_command->add_option("--record", serve.record,
                            "FILE.mcap: every sample without loss, and what was felt; `process "
                            "FILE.mcap` makes it anew");
  serve_command
      ->add_option("--record-limit", serve.record_limit,
                   "Size of all its files at which recording ends")
      ->capture_default_str();
  serve_command
      ->add_option("--record-part", serve.record_part,
                   "A new file after so many seconds: FILE-0001.mcap, FILE-0002.mcap; by the name "
                   "FILE.mcap they are processed and exported as one")
      ->check(CLI::Range(1.0, 1e6));

  ProcessOptions process;
  auto* process_command = add_command(
      "process", "Run over recorded pictures, or a recording (FILE.mcap), as fast as they go",
      &process);
  process_command->add_option("--out", process.out, "Folder for states.csv and summary.json")
      ->required();
  process_command->add_flag("--pictures", process.pictures,
                            "Also write every picture with what was seen drawn in");
  process_command->add_flag("--frames", process.frames,
                            "Also write every picture as it came: a recording to process again");
  process_command->add_flag("--points", process.points,
                            "Also write points.csv: the points that two cameras or depth pictures "
                            "follow, with sigma and disparity");
  process_command->add_option("--duration", process.duration,
                              "Seconds of a simulated target's path; files and scripted presses "
                              "end by themselves");

  RecordingExport exported;
  CLI::App* export_command = app.add_subcommand(
      "export", "Write a recording as NumPy arrays, pictures and its scene's files");
  export_command->add_option("file", exported.file, "FILE.mcap, as serve --record wrote it")
      ->required();
  export_command->add_option("--out", exported.out, "Folder, made if missing")->required();

  SolveOptions solve;
  auto* solve_command = add_command("solve", "Run the model alone on rows of a file", &solve);
  solve_command->add_option("--contacts", solve.contacts,
                            "CSV case,x,y,z,dx,dy,dz[,width][,t]; planar scenes need no z");
  solve_command->add_option("--loads", solve.loads,
                            "CSV case,x,y,z,fx,fy,fz[,width][,t]; t: a history for time: dynamic");
  solve_command->add_option("--out", solve.out, "CSV with one row per input row")->required();
  solve_command->add_option("--field", solve.field, "VTU of the deformed body");

  CheckOptions check;
  add_command("check", "Say what will run and why", &check);

  StudyOptions study;
  auto* study_command = add_command(
      "study", "Measure speed against accuracy of every model that fits the scene", &study);
  study_command->add_option("--out", study.out, "Folder for study.csv, study.json and study.svg")
      ->required();
  study_command->add_option("--budget", study.budget, "Seconds for all models together")
      ->capture_default_str();
  study_command->add_flag("--end-to-end", study.end_to_end,
                          "What each stage adds to the felt force's error instead");
  study_command->add_option("--delay", study.delay, "Of the link, with --end-to-end [s]")
      ->capture_default_str();

  TrainOptions train;
  CLI::App* train_command =
      app.add_subcommand("train", "Learn a fingertip's force network or localiser");
  AddTrainOptions(train_command, &train);

  IdentifyOptions identify;
  CLI::App* identify_command =
      app.add_subcommand("identify", "Constants of a material from tables of tests");
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
