#include "master/commands/arguments.h"

#include <array>
#include <stdexcept>
#include <string_view>

#include "master/device/device.h"
#include "master/recording/replay.h"
#include "master/station/live_station.h"
#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"

namespace palpate {
namespace {

// Two outputs must not share a regular file. A character device or pipe accepts both.
void RequireDistinct(std::string_view option, const std::filesystem::path& out,
                     std::string_view other_option, const std::filesystem::path& other) {
  if (out.empty() || other.empty()) return;
  std::error_code error;  // a file that does not exist yet has a path, too
  const auto status = std::filesystem::status(out, error);
  const bool is_file = !std::filesystem::exists(status) || is_regular_file(status);
  const auto place = std::filesystem::weakly_canonical(out, error);
  if (!is_file || std::filesystem::weakly_canonical(other, error) != place) return;
  throw std::invalid_argument(std::string(option) + " " + out.string() +
                              ": expected another file than that of " + std::string(other_option));
}

// Written so that NaN is rejected too.
CLI::Validator Between(double low, double high, const std::string& unit = "s") {
  return {[low, high, unit](const std::string& text) -> std::string {
            double value = 0;
            const bool number = CLI::detail::lexical_cast(text, value);
            if (number && value >= low && value <= high) return {};
            return text + ": expected " + CLI::detail::to_string(low) + " to " +
                   CLI::detail::to_string(high) + " " + unit;
          },
          ""};  // so that the help shows only the type name
}

void AddTls(CLI::App* command, std::filesystem::path* tls) {
  Add(command, "--tls", tls, "DIR",
      "Use mutual TLS 1.3 with ca.pem, cert.pem and key.pem of this folder "
      "(deploy/certs), also for --view")
      ->check(CLI::Validator(CLI::ExistingDirectory).description(""));
}

void AddLineOptions(CLI::App* command, SlaveLink::Options* link) {
  Add(command, "--wait", &link->wait, "S", "Time limit for connecting, in seconds")
      ->check(Between(0, 1e6))
      ->capture_default_str();
  AddTls(command, &link->tls);
  command->add_flag("--insecure", link->insecure,
                    "Allow plain text to other machines; without it only loopback is accepted");
}

void DeclareDoctor(CLI::App* app, DoctorArguments* a) {
  CLI::App* doctor = app->add_subcommand(
      "doctor", "Measure link, clock, priorities and device, and advise what to change");
  Add(doctor, "target", &a->link.target, "HOST:PORT",
      "Slave to examine without operating it; without it only this machine is examined");
  Add(doctor, "--device", &a->options.device, "DEVICE",
      "Haptic device to examine, as for connect; default: none");
  Add(doctor, "--seconds", &a->options.seconds, "S", "Duration of each measurement, in seconds")
      ->check(Between(0.1, 3600))
      ->capture_default_str();
  doctor->add_flag("--datagrams", a->link.datagrams,
                   "Test UDP too: takes the lease for a moment without engaging");
  AddLineOptions(doctor, &a->link);
}

void DeclareEvict(CLI::App* app, Arguments* a) {
  CLI::App* evict = app->add_subcommand(
      "evict", "End the lease of the slave's operator; with --tls it needs the role admin");
  evict->footer("Example:\n  palpate-master evict localhost:50051 --reason maintenance");
  Add(evict, "target", &a->link.target, "HOST:PORT", "Address of the slave")->required();
  Add(evict, "--reason", &a->reason, "TEXT", "Reason for the operator and the log");
  AddLineOptions(evict, &a->link);
}

void DeclareMotion(CLI::App* connect, Arguments* a) {
  Add(connect, "--axes", &a->axes, "AXES",
      "The device's axes for right, up and towards the operator, for example --axes=-z,y,x")
      ->capture_default_str();
  Add(connect, "--clutch-button", &a->clutch_button, "N",
      "Button of the device that opens the clutch while it is held; 0: none")
      ->check(CLI::Range(0, MotionOptions::kMaxButtons))
      ->capture_default_str();
  Add(connect, "--lock", &a->lock, "AXES",
      "Axes of the master that stay where the operator engages, for example z or x,z");
  Add(connect, "--box", &a->box, "BOX",
      "Box that the tool stays in, X,Y,Z:X,Y,Z: two opposite corners in mm, frame S");
  Add(connect, "--fixture", &a->fixtures, "FIXTURE",
      "Region that the tool stays in, in mm, frame S: plane:X,Y,Z:NX,NY,NZ, "
      "line:X,Y,Z:DX,DY,DZ[:RADIUS], sphere:X,Y,Z:RADIUS or cone:X,Y,Z:DX,DY,DZ:DEGREES; "
      "repeatable")
      ->allow_extra_args(false);
  Add(connect, "--contact-speed", &a->contact_speed, "MM/S",
      "Largest speed of the tool towards a surface that it reaches within 0.25 s, in mm/s")
      ->check(Between(1e-3, 1e3, "mm/s"));
}

void DeclareDevices(CLI::App* app) {
  app->add_subcommand(
         "devices", "List haptic devices: what was searched and found, what is missing, what to do")
      ->footer("Example:\n  palpate-master devices");
}

void DeclareRecordings(CLI::App* app, Arguments* a) {
  CLI::App* replay =
      app->add_subcommand("replay", "Show a recorded session on the operator's page");
  replay->footer(
      "Examples:\n"
      "  palpate-master replay session.mcap\n"
      "  palpate-master replay session.mcap --speed 0.5 --from 3 --view 127.0.0.1:8080");
  Add(replay, "file", &a->replay.file, "FILE.mcap", "Recording of connect --record")->required();
  Add(replay, "--speed", &a->replay.speed, "FACTOR", "Playback speed relative to real time")
      ->check(Between(Replay::kSlowest, Replay::kFastest, "times"))
      ->capture_default_str();
  Add(replay, "--from", &a->replay.from, "S", "Start time within the recording, in seconds")
      ->check(Between(0, 1e8))
      ->capture_default_str();
  Add(replay, "--view", &a->view, "[HOST:PORT]",
      "Address of the page, by default 127.0.0.1 on a free port")
      ->expected(0, 1);
  AddTls(replay, &a->link.tls);
}

}  // namespace

void Declare(CLI::App* app, Arguments* a, DoctorArguments* doctor) {
  app->require_subcommand(1);
  app->set_version_flag("--version", Version());
  app->footer(
      "Examples:\n"
      "  palpate-master connect localhost:50051\n"
      "  palpate-master connect localhost:50051 --duration 20 --report report.json --log log.csv\n"
      "  palpate-master doctor localhost:50051\n"
      "  palpate-master evict localhost:50051 --reason maintenance\n"
      "  palpate-master connect localhost:50051 --device pointer --view\n"
      "  palpate-master devices\n"
      "  palpate-master connect localhost:50051 --record session.mcap\n"
      "  palpate-master replay session.mcap --speed 0.5 --from 3\n"
      "  palpate-master replay session.mcap --view\n"
      "  palpate-master connect 10.0.0.7:50051 --insecure --device playback:hand.csv --render "
      "interpolate\n\n"
      "Emergency stop: Enter, or SIGUSR1. Reset: r and Enter, or SIGUSR2.\n"
      "Exit codes: 0 done, 1 ran and failed, 2 unusable arguments.");
  CLI::App* connect =
      app->add_subcommand("connect", "Operate a slave and render its contact force");
  Add(connect, "target", &a->link.target, "HOST:PORT", "Address of the slave")->required();
  Add(connect, "--device", &a->device, "DEVICE",
      "sim-hand, playback:FILE.csv (time_s,x,y,z), pointer (mouse, keys or gamepad on the page of "
      "--view), or touch, dhd, haply or spacemouse[:option]; see devices. Default: "
      "sim-hand if the slave is simulated, else none, and the master observes");
  connect
      ->add_option("--render", a->render,
                   "Force between two states: local model, interpolation, or newest force")
      ->check(CLI::IsMember({"local", "interpolate", "hold"}))
      ->capture_default_str();
  Add(connect, "--duration", &a->duration, "S",
      "Length of the run in seconds; default: until interrupted or the playback ends")
      ->check(Between(1e-3, 1e8));
  Add(connect, "--force-limit", &a->force_limit, "N",
      "Largest force on the device, in newtons; limits of scene and device also apply")
      ->check(Between(1e-3, 100, "N"))
      ->capture_default_str();
  Add(connect, "--slew-limit", &a->slew_limit, "N/ms",
      "Largest rate of change of the force on the device, in N/ms")
      ->check(Between(1e-6, 100, "N/ms"))
      ->capture_default_str();
  DeclareMotion(connect, a);
  Add(connect, "--report", &a->report, "FILE", "Write a summary of the run as JSON");
  Add(connect, "--log", &a->log, "FILE", "Write every tick as CSV");
  Add(connect, "--record", &a->record, "FILE.mcap",
      "Record ticks, states and commands, and images and shapes twice a second, for "
      "replay; to FILE-2.mcap, ... if it exists");
  Add(connect, "--record-limit", &a->record_limit, "SIZE",
      "Total size at which the recording ends; one hour takes 0.7 GB or more")
      ->capture_default_str();
  Add(connect, "--record-part", &a->record_part, "S",
      "Start a new file (FILE-0001.mcap, FILE-0002.mcap) after this many seconds; replay "
      "of FILE.mcap reads all of them")
      ->check(Between(1, 1e6));
  AddLineOptions(connect, &a->link);
  // Uses a function, because CLI11 would write `false` to an optional that was not set.
  connect->add_flag_function(
      "--datagrams,!--no-datagrams", [a](std::int64_t count) { a->link.datagrams = count > 0; },
      "Send states and commands also by UDP, encrypted with keys from the stream; default: on to "
      "other machines");
  CLI::Option* view =
      Add(connect, "--view", &a->view, "[HOST:PORT]",
          "Serve the operator's page, by default at 127.0.0.1 on a free port; beyond "
          "this machine it requires --tls and prints a token")
          ->expected(0, 1);
  Add(connect, "--setup-tls", &a->setup_tls, "DIR",
      "Certificate of an admin for the set-up of a slave from the page; default: that of --tls")
      ->check(CLI::Validator(CLI::ExistingDirectory).description(""));
  connect->callback([a, view] { a->views = view->count() > 0; });
  Add(connect, "--name", &a->link.operator_name, "NAME",
      "Name of the operator, which the slave shows to other clients; default: user and machine");
  DeclareDevices(app);
  DeclareEvict(app, a);
  DeclareRecordings(app, a);
  DeclareDoctor(app, doctor);
}

MotionOptions MotionOf(const Arguments& a) {
  constexpr double kMilli = 1e-3;
  MotionOptions motion;
  motion.axes = AxisMap::Parse(a.axes);
  motion.clutch_button = a.clutch_button;
  if (!a.lock.empty()) motion.ParseLocks(a.lock);
  if (!a.box.empty()) motion.box = Fixture::ParseBox(a.box);
  for (const std::string& fixture : a.fixtures) motion.fixtures.push_back(Fixture::Parse(fixture));
  motion.contact_speed = kMilli * a.contact_speed;
  return motion;
}

void RequireTimely(const std::filesystem::path& certificates) {
  if (certificates.empty()) return;
  RequireCertificates(certificates);
  const std::string untimely = WhyUntimely(certificates);
  if (!untimely.empty()) throw std::invalid_argument(untimely);
}

// Checks everything that can fail before anything moves.
void CheckBeforehand(const Arguments& a) {
  MotionOf(a);
  RequireTimely(a.link.tls);
  RequireTimely(a.setup_tls);
  const std::array inputs{PlaybackFile(a.device)};
  RequireOtherThan("--report", a.report, inputs);
  RequireOtherThan("--log", a.log, inputs);
  RequireOtherThan("--record", a.record, inputs);
  RequireDistinct("--log", a.log, "--report", a.report);
  RequireDistinct("--record", a.record, "--report", a.report);
  RequireDistinct("--record", a.record, "--log", a.log);
  if (a.views) ViewPlace(a.view, a.link.tls);
  if (IsPointer(a) && !a.views) {
    throw std::invalid_argument("--device pointer: only with --view, which serves its page");
  }
  RequireWritable(a.report);
  RequireWritable(a.log);
}

}  // namespace palpate
