// palpate-master: the operator's station.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <pwd.h>
#include <unistd.h>

#include "master/connect_recorder.h"
#include "master/device/device.h"
#include "master/doctor/doctor.h"
#include "master/link/channel.h"
#include "master/link/evict.h"
#include "master/link/slave_link.h"
#include "master/metrics/session_metrics.h"
#include "master/recording/replay.h"
#include "master/replay_command.h"
#include "master/session/session.h"
#include "master/station/live_station.h"
#include "master/view/console.h"
#include "master/view/keys.h"
#include "master/view/shape_watch.h"
#include "shared/link/loopback.h"
#include "shared/metrics/metrics_page.h"
#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "shared/tls/certificate.h"
#include "shared/tls/credentials.h"

namespace palpate {
namespace {

constexpr int kDone = 0, kFailed = 1, kUnusable = 2;
constexpr auto kLastWords = std::chrono::milliseconds(50);  // for the last command to leave
constexpr double kExamined = 1;  // duration of each measurement during a session [s]
constexpr auto kSignalPoll = std::chrono::milliseconds(10);

struct Arguments {
  SlaveLink::Options link;
  std::string device = "sim-hand";
  std::string render = "local";
  double duration = 0;
  double force_limit = 3.3, slew_limit = 0.2;  // the master's own [N], [N/ms]
  std::filesystem::path report, log, record;
  std::string record_limit = "8 GB";
  double record_part = 0;  // [s]; 0: one file
  std::string reason;      // of evict
  std::string metrics;     // HOST:PORT of the metrics page; empty: none
  std::vector<std::filesystem::path> shapes;
  bool views = false, replay_views = false, terminal = false;
  std::string view;  // HOST:PORT; empty: a free loopback port
  ReplayOptions replay;
  SessionExportOptions exported;
};

struct DoctorArguments {
  SlaveLink::Options link;  // an empty target: this machine alone
  DoctorOptions options;
};

// The link and the slots that must outlive it.
struct Line {
  explicit Line(const SlaveLink::Options& options) : link(options) {}
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  LatestValue<ReceivedPatch> patches;
  SlaveLink link;
};

// The values of `--metrics` and their page, which exists before the session.
struct Health {
  SessionMetrics seen;
  std::optional<MetricsPage> page;
};

std::atomic<bool> g_stop{false}, g_emergency{false}, g_reset{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void OnSignal(int) {
  g_stop = true;
}

// SIGINT, SIGTERM and SIGHUP end the session with the force at zero. SIGHUP stays ignored if the
// parent ignores it (nohup). SIGUSR1 requests the emergency stop, SIGUSR2 its reset. SIGPIPE is
// ignored: a closed pipe must not end the session.
void CatchSignals() {
  std::signal(SIGUSR1, [](int) { g_emergency = true; });
  std::signal(SIGUSR2, [](int) { g_reset = true; });
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  if (std::signal(SIGHUP, OnSignal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

// Gives up at a signal.
RemoteScene Connect(SlaveLink* link) {
  const std::jthread watch([link](const std::stop_token& done) {
    while (!done.stop_requested() && !g_stop) std::this_thread::sleep_for(kSignalPoll);
    if (!done.stop_requested()) link->Stop();
  });
  return link->Connect();
}

// Written so that NaN is rejected too.
CLI::Validator Between(double low, double high, const std::string& unit = "s") {
  return {[low, high, unit](const std::string& text) -> std::string {
            double value = 0;
            const bool number = CLI::detail::lexical_cast(text, value);
            if (number && value >= low && value <= high) return {};
            return text + ": accepted is " + CLI::detail::to_string(low) + " to " +
                   CLI::detail::to_string(high) + " " + unit;
          },
          ""};  // The help shows the type name alone.
}

// Adds an option whose help shows `type`, such as FILE or HOST:PORT.
template <class T>
CLI::Option* Add(CLI::App* command, const char* name, T* value, const char* type,
                 const char* text) {
  return command->add_option(name, *value, text)->type_name(type);
}

void AddTls(CLI::App* command, SlaveLink::Options* link) {
  Add(command, "--tls", &link->tls, "DIR",
      "Use mutual TLS 1.3 with ca.pem, cert.pem and key.pem of this folder "
      "(deploy/certs), also for --view")
      ->check(CLI::Validator(CLI::ExistingDirectory).description(""));
}

void AddLineOptions(CLI::App* command, SlaveLink::Options* link) {
  Add(command, "--wait", &link->wait, "S", "Time limit for connecting, in seconds")
      ->check(Between(0, 1e6))
      ->capture_default_str();
  AddTls(command, link);
  command->add_flag("--insecure", link->insecure,
                    "Allow plain text to other machines; without it only loopback is accepted");
}

void DeclareDoctor(CLI::App* app, DoctorArguments* a) {
  CLI::App* doctor = app->add_subcommand(
      "doctor", "Measure link, clock, priorities and device, and advise what to change");
  Add(doctor, "target", &a->link.target, "HOST:PORT",
      "Slave to examine without operating it; without it only this machine is examined");
  Add(doctor, "--device", &a->options.device, "DEVICE", "Haptic device, as for connect")
      ->capture_default_str();
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

void DeclareRecordings(CLI::App* app, Arguments* a) {
  CLI::App* replay = app->add_subcommand("replay", "Show a recorded session");
  replay->footer(
      "Examples:\n"
      "  palpate-master replay session.mcap --speed 0.5 --from 3\n"
      "  palpate-master replay session.mcap --view");
  Add(replay, "file", &a->replay.file, "FILE.mcap", "Recording of connect --record")->required();
  Add(replay, "--speed", &a->replay.speed, "FACTOR", "Playback speed relative to real time")
      ->check(Between(Replay::kSlowest, Replay::kFastest, "times"))
      ->capture_default_str();
  Add(replay, "--from", &a->replay.from, "S", "Start time within the recording, in seconds")
      ->check(Between(0, 1e8))
      ->capture_default_str();
  CLI::Option* view = Add(replay, "--view", &a->view, "[HOST:PORT]",
                          "Show it on the operator's page, by default at 127.0.0.1 on a free port")
                          ->expected(0, 1);
  AddTls(replay, &a->link);
  replay->callback([a, view] { a->replay_views = view->count() > 0; });
  CLI::App* exported = app->add_subcommand(
      "export", "Write a recording as CSV tables, NumPy arrays, images and VTU meshes");
  exported->footer("Example:\n  palpate-master export session.mcap --out session");
  Add(exported, "file", &a->exported.file, "FILE.mcap", "Recording of connect --record")
      ->required();
  Add(exported, "--out", &a->exported.out, "DIR", "Output folder; it is created if missing")
      ->required();
}

void Declare(CLI::App* app, Arguments* a) {
  app->require_subcommand(1);
  app->set_version_flag("--version", Version());
  app->footer(
      "Examples:\n"
      "  palpate-master connect localhost:50051\n"
      "  palpate-master connect localhost:50051 --duration 20 --report report.json --log log.csv\n"
      "  palpate-master connect localhost:50051 --shape pinch.svg\n"
      "  palpate-master doctor localhost:50051\n"
      "  palpate-master evict localhost:50051 --reason maintenance\n"
      "  palpate-master connect localhost:50051 --device pointer --view\n"
      "  palpate-master connect localhost:50051 --tui\n"
      "  palpate-master connect localhost:50051 --record session.mcap\n"
      "  palpate-master replay session.mcap --speed 0.5 --from 3\n"
      "  palpate-master replay session.mcap --view\n"
      "  palpate-master export session.mcap --out session\n"
      "  palpate-master connect 10.0.0.7:50051 --insecure --device playback:hand.csv --render "
      "interpolate\n\n"
      "Emergency stop: Enter, or SIGUSR1. Reset: r and Enter, or SIGUSR2.\n"
      "Exit codes: 0 done, 1 ran and failed, 2 unusable arguments.");
  CLI::App* connect =
      app->add_subcommand("connect", "Operate a slave and render its contact force");
  Add(connect, "target", &a->link.target, "HOST:PORT", "Address of the slave")->required();
  Add(connect, "--device", &a->device, "DEVICE",
      "sim-hand, playback:FILE.csv (time_s,x,y,z), or pointer (mouse, keys or gamepad "
      "on the page of --view)")
      ->capture_default_str();
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
  Add(connect, "--report", &a->report, "FILE", "Write a summary of the run as JSON");
  Add(connect, "--log", &a->log, "FILE", "Write every tick as CSV");
  Add(connect, "--record", &a->record, "FILE.mcap",
      "Record ticks, states and commands, and images and shapes twice a second, for "
      "replay and export");
  Add(connect, "--record-limit", &a->record_limit, "SIZE",
      "Total size at which the recording ends; one hour takes 0.6 GB or more")
      ->capture_default_str();
  Add(connect, "--record-part", &a->record_part, "S",
      "Start a new file (FILE-0001.mcap, FILE-0002.mcap) after this many seconds; replay "
      "and export of FILE.mcap read all of them")
      ->check(Between(1, 1e6));
  Add(connect, "--shape", &a->shapes, "FILE.svg|FILE.vtu",
      "Write the deformed object and the fingertip forces once a second, and FILE-deepest "
      "(largest deflection) at the end; repeatable")
      ->allow_extra_args(false);
  AddLineOptions(connect, &a->link);
  // A function, because CLI11 would write `false` into an optional that nobody set.
  connect->add_flag_function(
      "--datagrams,!--no-datagrams", [a](std::int64_t count) { a->link.datagrams = count > 0; },
      "Send states and commands also by UDP, encrypted with keys from the stream; default: on to "
      "other machines");
  Add(connect, "--metrics", &a->metrics, "HOST:PORT",
      "Serve health metrics for Prometheus at http://HOST:PORT/metrics");
  CLI::Option* view =
      Add(connect, "--view", &a->view, "[HOST:PORT]",
          "Serve the operator's page, by default at 127.0.0.1 on a free port; beyond "
          "this machine it requires --tls and prints a token")
          ->expected(0, 1);
  connect->add_flag("--tui", a->terminal,
                    "Show state, force, link, alarms and keys in the terminal instead of one line");
  connect->callback([a, view] { a->views = view->count() > 0; });
  Add(connect, "--name", &a->link.operator_name, "NAME",
      "Name of the operator, which the slave shows to other clients; default: user, machine and "
      "process");
  DeclareEvict(app, a);
  DeclareRecordings(app, a);
}

bool IsPointer(const Arguments& a) {
  return a.device == "pointer";
}

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
                              ": accepted is another file than that of " +
                              std::string(other_option));
}

void RequireTimely(const std::filesystem::path& certificates) {
  if (certificates.empty()) return;
  RequireCertificates(certificates);
  const std::string untimely = WhyUntimely(certificates);
  if (!untimely.empty()) throw std::invalid_argument(untimely);
}

// Checks everything that can fail before anything moves.
void CheckBeforehand(const Arguments& a) {
  RequireTimely(a.link.tls);
  const std::array inputs{PlaybackFile(a.device)};
  RequireOtherThan("--report", a.report, inputs);
  RequireOtherThan("--log", a.log, inputs);
  RequireOtherThan("--record", a.record, inputs);
  for (const auto& shape : a.shapes) RequireOtherThan("--shape", shape, inputs);
  RequireDistinct("--log", a.log, "--report", a.report);
  RequireDistinct("--record", a.record, "--report", a.report);
  RequireDistinct("--record", a.record, "--log", a.log);
  if (a.views) ViewPlace(a.view, a.link.tls);
  if (IsPointer(a) && !a.views) {
    throw std::invalid_argument("--device pointer: accepted is with --view, which serves its page");
  }
  RequireWritable(a.report);
  RequireWritable(a.log);
  for (const auto& shape : a.shapes) {
    CheckShapeFile(shape);
    RequireWritable(shape);
  }
}

// Whether the device can be made only when the scene is known.
bool IsMadeForScene(const Arguments& a) {
  return a.device == "sim-hand" || IsPointer(a);
}

// Largest age of a rendered sample [s]: larger for a slow sensor, up to a limit.
double OldestShown(double sensor_rate) {
  constexpr double kOnTop = 0.1, kLeast = 0.06, kMost = 1, kPeriods = 3;  // [s], [s], [s], [-]
  return kOnTop + std::clamp(kPeriods / std::max(sensor_rate, kPeriods), kLeast, kMost);
}

HapticLoop::Options LoopOptions(const Arguments& a, const RemoteScene& scene) {
  HapticLoop::Options options;
  options.render = *ParseRenderMode(a.render);
  options.transform = scene.transform;
  options.force_limit = std::min(a.force_limit, scene.force_limit);
  options.slew_limit = a.slew_limit;
  options.max_age = OldestShown(scene.sensor_rate);
  options.dead_after = scene.dead_after;
  options.settings_revision = scene.settings_revision;
  return options;
}

// The pointer is twice as fast as the simulated operator, so that it follows a drag.
std::unique_ptr<Device> OpenDeviceFor(const RemoteScene& scene, const Arguments& a) {
  constexpr double kFaster = 2, kUsual = 0.02;  // [-], [m/s]
  const double scale = scene.transform.position_scale;
  const double speed = scene.press_speed > 0 ? scene.press_speed / scale : kUsual;
  if (IsPointer(a)) return std::make_unique<Pointer>(kFaster * speed);
  return OpenDevice(a.device, scene.press_depth / scale, scene.press_speed / scale);
}

// Expiry of the certificate in `folder` since 1970 [s]; nullopt: there is none.
std::optional<double> CertificateUntil(const std::filesystem::path& folder) {
  std::ifstream file(folder / "cert.pem");
  const std::string pem{std::istreambuf_iterator<char>(file), {}};
  const auto facts = folder.empty() ? std::nullopt : FactsOf(pem);
  if (!facts) return std::nullopt;
  return std::chrono::duration<double>(facts->until.time_since_epoch()).count();
}

// A second link beside the operating one: it only observes, and does not wait.
SlaveLink::Options LineToExamine(const SlaveLink::Options& line) {
  SlaveLink::Options watched;
  watched.target = line.target;
  watched.wait = 0;
  watched.insecure = line.insecure;
  watched.tls = line.tls;
  return watched;
}

// Null: neither --view nor --tui.
std::unique_ptr<LiveStation> OpenStation(const Arguments& a, const RemoteScene& scene,
                                         SlaveLink* link, Device* device,
                                         OperatorRequests* requests, ConnectRecorder* recorder) {
  if (!a.views && !a.terminal) return nullptr;
  StationHello hello;
  hello.scene = scene;
  hello.target = a.link.target;
  hello.device = device->description();
  hello.render = a.render;
  hello.version = Version();
  hello.encrypted = !a.link.tls.empty();
  hello.pointer = IsPointer(a);
  hello.certificate_until = CertificateUntil(a.link.tls);
  LiveStation::Controls controls{
      [] { g_emergency = true; },
      [link] { return link->Reset(); },
      [link](const SlaveLink::Mapping& mapping) { return link->SetMapping(mapping); },
      [link](const std::string& kind) { return link->SetModel(kind); },
      [link] { return link->ReinitializeTracking(); },
      [line = LineToExamine(a.link), found = FoundOf(*device)](const std::stop_token& stop) {
        return Examine(found, line, kExamined, stop);
      }};
  if (recorder != nullptr) {
    controls.record = [recorder](bool on) { recorder->Switch(on); };
    controls.recording = [recorder] { return recorder->moment(); };
  }
  controls.quit = [] { g_stop = true; };
  LiveStation::Options options{{},       a.link,    hello, dynamic_cast<Pointer*>(device),
                               requests, a.terminal};
  if (a.views) options.at = ViewPlace(a.view, a.link.tls);
  return std::make_unique<LiveStation>(std::move(options), std::move(controls));
}

// Settings of the session, for its recording.
McapMap NoteOf(const Arguments& a, const RemoteScene& scene, const Device& device) {
  return {{"scene", scene.name},
          {"model", scene.model},
          {"source", scene.source},
          {"device", device.description()},
          {"render", a.render},
          {"force_limit_N", Formatted("%.9g", std::min(a.force_limit, scene.force_limit))},
          {"slew_limit_N_per_ms", Formatted("%.9g", a.slew_limit)},
          {"position_scale", Formatted("%.9g", scene.transform.position_scale)},
          {"force_scale", Formatted("%.9g", scene.transform.force_scale)}};
}

int Operate(const Arguments& a, Line* line, std::unique_ptr<Device> device,
            ConnectRecorder* recorder, Health* health) {
  Console console = Console::Standard();
  const RemoteScene scene = Connect(&line->link);
  if (!device) device = OpenDeviceFor(scene, a);
  console.Print("connected to " + a.link.target + ": " + scene.name + ", " + scene.model + ", " +
                scene.source);
  const std::string other = OtherRelease(scene.version, Version());
  if (!other.empty()) console.Print(other + " Install the same release at both ends.");
  if (!scene.fingertips.empty()) console.Print(FingertipsInWords(scene.fingertips));
  if (a.link.tls.empty() && !IsLoopback(ParseEndpoint(a.link.target).host)) {
    console.Print(
        "--insecure: plain text without authentication: an unknown slave may render up to " +
        Formatted("%g N", a.force_limit));
  }
  console.Print("device " + device->description() + "; rendering " + a.render);

  if (recorder) recorder->Begin(a.link, NoteOf(a, scene, *device));
  line->link.Start(&line->states, &line->commands, &line->settings);
  SessionOptions options;
  options.loop = LoopOptions(a, scene);
  options.settings = &line->settings;
  OperatorRequests requests(options.loop.render);
  options.requests = &requests;
  std::optional<PatchWatch> patch;
  if (options.loop.render == RenderMode::kLocal || a.views || a.terminal) {
    patch.emplace(PatchWatch::Options{a.link.target, a.link.insecure, a.link.tls,
                                      line->link.longest_round_trip()},
                  &line->patches);
    options.patches = &line->patches;
    options.patch_stats = [&patch] { return patch->stats(); };
  }
  options.emergency = {[] { return g_emergency.exchange(false); },
                       [line] { return line->link.EmergencyStop("by the operator's station"); },
                       [line] { line->link.GiveUpStop(); }};
  options.duration = a.duration;
  options.log = a.log;
  for (const RemoteFingertip& tip : scene.fingertips) options.finger_names.push_back(tip.name);
  if (health->page) {
    console.Print("metrics at http://" + ToString(health->page->endpoint()) + "/metrics");
  }
  auto station = OpenStation(a, scene, &line->link, device.get(), &requests, recorder);
  if (station) {
    if (a.views) console.Print("view at " + station->address());
    options.see_tick = [&station](const TickRecord& tick) { station->OnTick(tick); };
  }
  std::optional<Keys> keys;
  if (!a.terminal) keys.emplace([] { g_emergency = true; }, [] { g_reset = true; });
  SlaveLink::Options told = a.link;
  told.longest_round_trip = line->link.longest_round_trip();
  ShapeWatch shape(told, scene, a.shapes, console.live());
  if (recorder) recorder->AddOnlooker(&options.see_tick);
  Report report = RunSession(
      options, *device, &line->states, &line->commands, [line] { return line->link.stats(); },
      [line] { return g_stop.load() || line->link.denied(); },
      [&](const Status& status) {
        if (g_reset.exchange(false)) {
          const bool done = line->link.Reset();
          if (!a.terminal)
            console.Print(done ? "the emergency stop was reset"
                               : "the slave did not reset the stop: try again");
        }
        if (!a.terminal) console.Show(status, shape.newest().get());
        if (station) station->Update(status);
        shape.Update(status);
        health->seen.Update(status);
      });
  station.reset();
  std::this_thread::sleep_for(kLastWords);
  line->link.Stop();
  patch.reset();
  const bool shapes_written = shape.Finish(&report);
  const bool recorded = !recorder || recorder->Finish(&console, &report);

  report.scene = scene.name;
  report.model = scene.model;
  console.Print(FormatSummary(report));
  if (!a.report.empty()) WriteReport(report, a.report);
  const bool never_served = report.link.states == 0 && !g_stop;
  if (never_served) {
    const std::string& why = report.link.trouble;
    console.Print("failed: the slave never sent a state" + (why.empty() ? why : ": " + why));
  }
  return report.log_failed || never_served || !shapes_written || !recorded ? kFailed : kDone;
}

// Runs `replay` or `export` until it is done, or a signal comes.
int ReadRecording(const CLI::App& app, const Arguments& a) {
  CatchSignals();
  std::stop_source source;
  const std::jthread watch([&](const std::stop_token& done) {
    while (!done.stop_requested() && !g_stop) std::this_thread::sleep_for(kSignalPoll);
    source.request_stop();
  });
  if (a.replay_views)
    return ViewReplay(a.replay, ViewPlace(a.view, a.link.tls), source.get_token());
  if (app.got_subcommand("replay")) return RunReplay(a.replay, source.get_token());
  RequireOtherThan("--out", a.exported.out, {"log.csv", "states.csv"}, std::array{a.exported.file});
  return RunExport(a.exported, source.get_token());
}

int Evict(const Arguments& a) {
  try {
    const std::string name = EvictOperator(a.link, a.reason);
    std::printf("evicted %s\n", name.empty() ? "the operator" : name.c_str());
    return kDone;
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "palpate-master: %s: %s\n", a.link.target.c_str(), error.what());
    return kFailed;
  }
}

// Such as `ada@desk, process 4711`: a name that a reconnecting program has and no other.
std::string NameOfProcess() {
  const passwd* user = getpwuid(getuid());
  std::array<char, HOST_NAME_MAX + 1> host{};
  gethostname(host.data(), host.size() - 1);
  return std::string(user != nullptr ? user->pw_name : "operator") + "@" + host.data() +
         ", process " + std::to_string(getpid());
}

int Main(int argc, char** argv) {
  Arguments a;
  DoctorArguments doctor;
  CLI::App app("palpate-master: operates a slave and renders its contact force");
  Declare(&app, &a);
  DeclareDoctor(&app, &doctor);
  std::unique_ptr<ConnectRecorder> recorder;  // outlives the link
  std::unique_ptr<Line> line;
  std::unique_ptr<Device> device;
  Health health;
  try {
    app.parse(argc, argv);
    if (app.got_subcommand("doctor")) {
      RequireTimely(doctor.link.tls);
      if (!doctor.link.target.empty()) doctor.options.line = doctor.link;
      return RunDoctor(doctor.options);
    }
    if (app.got_subcommand("replay") || app.got_subcommand("export")) return ReadRecording(app, a);
    if (app.got_subcommand("evict")) return Evict(a);
    CheckBeforehand(a);
    if (a.link.operator_name.empty()) a.link.operator_name = NameOfProcess();
    NameCalls(a.link.operator_name);
    if (!a.metrics.empty()) {
      health.page.emplace(a.metrics, a.link.insecure, [&] { return health.seen.Collect(); });
    }
    if (!a.record.empty()) {
      recorder =
          std::make_unique<ConnectRecorder>(a.record, a.record_limit, a.record_part, &a.link);
    }
    line = std::make_unique<Line>(a.link);
    if (!IsMadeForScene(a)) device = OpenDevice(a.device, 0, 0);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUnusable;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpate-master: %s\n", error.what());
    return kUnusable;
  }
  CatchSignals();
  try {
    return Operate(a, line.get(), std::move(device), recorder.get(), &health);
  } catch (const std::exception& error) {
    if (g_stop) return kDone;  // before anything moved
    std::fprintf(stderr, "palpate-master: %s\n", error.what());
    return kFailed;
  }
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
