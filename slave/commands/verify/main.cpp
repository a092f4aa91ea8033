// palpate-verify: the command line of `palpate-slave verify`.
#include "slave/commands/command_program.h"
#include "slave/commands/verify/verify.h"

namespace palpate {
namespace {

constexpr const char* kExamples =
    R"(It compares a table of measured and estimated forces: --forces, or the one that a run of the scene
makes and keeps in forces.csv. Columns: measured_fx to measured_fz and estimated_fx to estimated_fz,
of which axes may be absent, and if known t, sigma and validity (`valid`, 1 or true). Rows without t
are taken in their order. With a scene, causes are named in its words.

The measured forces of a run are those of --sensor, of --loads, or of the answers to questions: one
known load after the other, while a slave serves the scene. Table of loads, SI, frame S, force of the
object on the tool:
  t,until,fx,fy,fz[,sigma][,x,y,z][,depth][,finger]    loads that were held from t to until
  t,fx,fy,fz[,sigma][,x,y,z][,depth][,finger]          record of a sensor, linear between rows
t is the time since the first state. x,y,z is the known position of the tip, depth the known
indentation, sigma that of each axis of the force (default 1 % of it). An empty cell is
unknown. fx,fy,fz may be absent if only positions are known.

Examples:
  palpate-slave verify deploy/scenes/silicone-block.yaml --out build/card
  palpate-slave verify deploy/scenes/silicone-block.yaml --sensor --out build/card
  palpate-slave verify slave.mcap --loads loads.csv --out build/card
  palpate-slave verify scene.yaml --states states.csv --loads loads.csv --out build/card
  palpate-slave verify scene.yaml --connect 127.0.0.1:50051 --sensor --duration 30 --out build/card
  palpate-slave verify --forces forces.csv --out build/card
  palpate-slave verify --forces log.csv --measured Fz --estimated pred --measured-unit g --out card
  palpate-slave verify scene.yaml --forces card/forces.csv --out again

Exit codes: 0 all that was tested is right, 1 something is wrong or not decided, 2 unusable
arguments or scene.)";

void AddForceOptions(CLI::App* command, VerifyOptions* options) {
  ForceColumns& columns = options->columns;
  Add(command, "--forces", &options->forces, "FILE",
      "Measured and estimated forces of any source: CSV, see below")
      ->check(CLI::ExistingFile);
  AddShown(command, "--measured", &columns.measured, "Columns of the measured force; - for none");
  AddShown(command, "--estimated", &columns.estimated, "Columns of the estimated force");
  AddShown(command, "--time", &columns.time, "Column of the time");
  AddShown(command, "--sigma", &columns.sigma, "Column of sigma, in the unit of the estimate");
  AddShown(command, "--validity", &columns.validity, "Column of the validity");
  AddShown(command, "--measured-unit", &columns.measured_unit,
           "Unit of the measured force: N, mN, uN, kN, g, kgf or lbf");
  AddShown(command, "--estimated-unit", &columns.estimated_unit, "Unit of the estimated force");
  AddShown(command, "--time-unit", &columns.time_unit, "Unit of the time: s, ms, us, ns, min or h");
}

void AddOptions(CLI::App* command, VerifyOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  command->get_option("scene")
      ->description("Scene file (YAML), or a recording of the slave (FILE.mcap)")
      ->required(false);
  Add(command, "--out", &options->out, "DIR", "Folder for report.json and forces.csv")->required();
  AddForceOptions(command, options);
  Add(command, "--loads", &options->loads, "FILE", "Known loads: CSV, see below")
      ->check(CLI::ExistingFile);
  command->add_flag("--sensor", options->sensor,
                    "Compare with the force sensor of the manipulator's driver "
                    "(ArmReport.measured_force), or with a simulator's true force");
  Add(command, "--states", &options->states, "FILE",
      "Reported states: states.csv of `process`; default: the scene is processed")
      ->check(CLI::ExistingFile);
  Add(command, "--connect", &options->connect, "HOST:PORT",
      "Slave that serves the scene; for questions default 127.0.0.1:50051");
  command->add_option("--tls", options->tls, "Mutual TLS 1.3: folder of certificates")
      ->check(CLI::ExistingDirectory);
  command->add_flag("--insecure", options->insecure,
                    "Allow addresses that are not loopback, in plain text");
  AddShown(command, "--duration", &options->duration,
           "Seconds for which --connect watches the slave")
      ->check(CLI::Range(0.1, 86400.0));
  AddShown(command, "--hold", &options->hold,
           "Seconds for which each load is held in answer to a question")
      ->check(CLI::Range(0.1, 600.0));
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "verify", palpate::kExamples, palpate::AddOptions,
                                    palpate::RunVerify);
}
