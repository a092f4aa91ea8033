#include "master/commands/operate.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

#include <poll.h>
#include <unistd.h>

#include "master/device/no_device.h"
#include "master/device/sim_hand.h"
#include "master/link/operator_calls.h"
#include "master/link/setup_calls.h"
#include "master/session/session.h"
#include "master/station/live_station.h"
#include "master/view/console.h"
#include "shared/link/loopback.h"
#include "shared/link/task_queue.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"

namespace palpate {
namespace {

constexpr int kPollMs = 100;  // period at which the loop checks whether to end [ms]

// Returns a line of the terminal, or its available part; empty: none within the poll time. nullopt:
// the terminal was closed, after which it would always be readable.
std::optional<std::string_view> TypedLine(std::array<char, 256>* buffer) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (poll(&input, 1, kPollMs) <= 0) return std::string_view();
  if ((input.revents & ~POLLIN) != 0) return std::nullopt;
  const ssize_t size = read(STDIN_FILENO, buffer->data(), buffer->size());
  return size > 0 ? std::string_view(buffer->data(), static_cast<std::size_t>(size))
                  : std::string_view();
}

// Keys of the terminal: Enter is the emergency stop, `r` and Enter resets it. Without a terminal
// there are no keys.
class Keys {
 public:
  // Both are called on a separate thread: `reset` after "r", `stop` after any other input.
  Keys(std::function<void()> stop, std::function<void()> reset) {
    if (isatty(STDIN_FILENO) == 0) return;
    thread_ = std::jthread(
        [stop = std::move(stop), reset = std::move(reset)](const std::stop_token& ended) {
          std::array<char, 256> buffer{};
          while (!ended.stop_requested()) {
            const auto line = TypedLine(&buffer);
            if (!line) return;
            if (!line->empty()) (*line == "r\n" ? reset : stop)();
          }
        });
  }

 private:
  std::jthread thread_;
};

constexpr auto kLastWords = std::chrono::milliseconds(50);  // time to send the last command
constexpr std::size_t kMaxResets = 4;                       // largest number of waiting resets

// Connects to the slave; a signal cancels it.
RemoteScene Connect(SlaveLink* link) {
  const std::jthread watch([link](const std::stop_token& done) {
    while (!done.stop_requested() && !g_stop) std::this_thread::sleep_for(kSignalPoll);
    if (!done.stop_requested()) link->Stop();
  });
  return link->Connect();
}

HapticLoop::Options LoopOptions(const Arguments& a, const RemoteScene& scene,
                                std::chrono::milliseconds max_round_trip) {
  HapticLoop::Options options;
  options.render = *ParseRenderMode(a.render);
  options.transform = scene.transform;
  options.force_limit = std::min(a.force_limit, scene.force_limit);
  options.slew_limit = a.slew_limit;
  options.max_age = MaxAge(scene.sensor_rate);
  options.max_trip = std::chrono::duration<double>(max_round_trip).count();
  options.dead_after = scene.dead_after;
  options.settings_revision = scene.settings_revision;
  options.motion = MotionOf(a);
  return options;
}

// A script must not press a real arm into the object unless somebody asks for it by name.
bool OnlyObserves(const Arguments& a, const RemoteScene& scene) {
  return a.device.empty() && !scene.simulated;
}

// What a person must know before the first motion; empty: nothing.
std::string WarningOf(const Arguments& a, const RemoteScene& scene) {
  constexpr double kMilli = 1e3;
  if (OnlyObserves(a, scene)) {
    return "no --device: this slave moves a real tool, so this master observes it; operate with a "
           "device (palpate-master devices), or by mouse with --device pointer --view";
  }
  if (a.device != "sim-hand" || scene.simulated) return {};
  return Formatted(
      "sim-hand: a script presses the REAL tool %g mm into the object every %g s, with the force "
      "that this needs; only the scene's guards of force and depth bound it. Ctrl+C ends it",
      kMilli * scene.press_depth, PressScript::kPeriod);
}

// The pointer is twice as fast as the simulated operator, so that it follows a drag. A slave that
// is being set up has no speed yet.
std::unique_ptr<Device> OpenDeviceFor(const RemoteScene& scene, const Arguments& a) {
  constexpr double kFaster = 2, kUsual = 0.02;  // [-], [m/s]
  const double scale = scene.transform.position_scale;
  const double speed = scene.press_speed > 0 ? scene.press_speed / scale : kUsual;
  if (IsPointer(a)) return std::make_unique<Pointer>(kFaster * speed);
  if (OnlyObserves(a, scene)) return std::make_unique<NoDevice>();
  return OpenDevice("sim-hand", scene.press_depth / scale, speed);
}

// Expiry of the certificate in `folder` since 1970 [s]; nullopt: there is none.
std::optional<double> CertificateUntil(const std::filesystem::path& folder) {
  std::ifstream file(folder / "cert.pem");
  const std::string pem{std::istreambuf_iterator<char>(file), {}};
  const auto expiry = folder.empty() ? std::nullopt : ExpiryOf(pem);
  if (!expiry) return std::nullopt;
  return std::chrono::duration<double>(expiry->time_since_epoch()).count();
}

// Opens the streams that loop, page and recording need, on one connection.
std::unique_ptr<Observer> OpenObserver(const Arguments& a, RenderMode render, Line* line,
                                       ConnectRecorder* recorder) {
  SlaveLink::Options link = a.link;
  link.max_round_trip = line->link.max_round_trip();
  Observer::Options options;
  if (render == RenderMode::kLocal || a.views) options.patches = &line->patches;
  options.health = a.views;
  if (recorder != nullptr) options.on_message = recorder->on_message();
  auto observer = std::make_unique<Observer>(link, std::move(options));
  if (recorder != nullptr) observer->Need(Observer::User::kRecording, SessionRecording::kViews);
  return observer;
}

// Returns the station of the web page; null without --view.
std::unique_ptr<LiveStation> OpenStation(const Arguments& a, const RemoteScene& scene,
                                         SlaveLink* link, Device* device,
                                         OperatorRequests* requests, ConnectRecorder* recorder,
                                         Observer* observer) {
  if (!a.views) return nullptr;
  StationHello hello;
  hello.scene = scene;
  hello.target = a.link.target;
  hello.device = device->description();
  hello.render = a.render;
  hello.version = Version();
  hello.encrypted = !a.link.tls.empty();
  hello.pointer = IsPointer(a);
  hello.only_observes = OnlyObserves(a, scene);
  hello.certificate_until = CertificateUntil(a.link.tls);
  SlaveLink::Options setup = a.link;
  if (!a.setup_tls.empty()) setup.tls = a.setup_tls;
  LiveStation::Controls controls{
      [link] { return link->state(); },
      [link] { return link->TakeEvents(); },
      RequestEmergencyStop,
      [link](std::uint64_t stops) { return link->calls().Reset(stops); },
      [link](const SlaveLink::Mapping& mapping) { return link->calls().SetMapping(mapping); },
      [link](const std::string& kind) { return link->calls().SetModel(kind); },
      [link] { return link->calls().ReinitializeTracking(); },
      [calls = std::make_shared<SetupCalls>(setup)](
          const std::string& call, const std::string& json, const std::stop_token& stop) {
        return calls->Make(call, json, stop);
      }};
  if (recorder != nullptr) {
    controls.record = [recorder](bool on) { recorder->Switch(on); };
    controls.recording = [recorder] { return recorder->moment(); };
  }
  LiveStation::Options options{ViewPlace(a.view, a.link.tls), hello, observer,
                               dynamic_cast<Pointer*>(device), requests};
  return std::make_unique<LiveStation>(std::move(options), std::move(controls));
}

// Settings of the session, for its recording.
McapMap NoteOf(const Arguments& a, const RemoteScene& scene, const Device& device) {
  McapMap note{{"scene", scene.name},
               {"model", scene.model},
               {"source", scene.source},
               {"device", device.description()},
               {"render", a.render},
               {"force_limit_N", Formatted("%.9g", std::min(a.force_limit, scene.force_limit))},
               {"slew_limit_N_per_ms", Formatted("%.9g", a.slew_limit)},
               {"position_scale", Formatted("%.9g", scene.transform.position_scale)},
               {"force_scale", Formatted("%.9g", scene.transform.force_scale)}};
  return note;
}

void OnSignal(int) {
  g_stop = true;
}

}  // namespace

int Operate(const Arguments& a, Line* line, std::unique_ptr<Device> device,
            ConnectRecorder* recorder) {
  Console console = Console::Standard();
  const RemoteScene scene = Connect(&line->link);
  if (!device) device = OpenDeviceFor(scene, a);
  console.Print("connected to " + a.link.target + ": " +
                (scene.name.empty() ? "set-up, without a scene yet"
                                    : scene.name + ", " + scene.model + ", " + scene.source));
  const std::string other = OtherRelease(scene.version, Version());
  if (!other.empty()) console.Print(other + " Install the same release at both ends.");
  if (!scene.fingertips.empty()) console.Print(FingertipsInWords(scene.fingertips));
  if (a.link.tls.empty() && !IsLoopback(ParseEndpoint(a.link.target).host)) {
    console.Print(
        "--insecure: plain text without authentication: an unknown slave may render up to " +
        Formatted("%g N", a.force_limit));
  }
  console.Print("device " + device->description() + "; rendering " + a.render);
  if (const std::string warning = WarningOf(a, scene); !warning.empty()) console.Print(warning);

  if (recorder) {
    recorder->Begin(a.link.target, NoteOf(a, scene, *device));
    console.Print("recording to " + recorder->file().string());
  }
  line->link.Start(&line->states, &line->commands, &line->settings, !OnlyObserves(a, scene));
  SessionOptions options;
  options.loop = LoopOptions(a, scene, line->link.max_round_trip());
  options.settings = &line->settings;
  OperatorRequests requests(options.loop.render);
  options.requests = &requests;
  auto observer = OpenObserver(a, options.loop.render, line, recorder);
  options.patches = &line->patches;
  options.patch_stats = [&observer] { return observer->patch_stats(); };
  options.emergency = {
      [line] {
        const bool is_requested = g_emergency.exchange(false);
        if (is_requested) line->link.calls().CancelReset();
        return is_requested;
      },
      [line] { return line->link.calls().EmergencyStop("by the operator's station"); },
      [line] { line->link.calls().GiveUpStop(); }};
  options.duration = a.duration;
  options.log = a.log;
  options.sensor_rate = scene.sensor_rate;
  for (const RemoteFingertip& tip : scene.fingertips) options.finger_names.push_back(tip.name);
  auto station =
      OpenStation(a, scene, &line->link, device.get(), &requests, recorder, observer.get());
  options.notify = [&](const std::string& notice) {
    console.Print(notice);
    if (station) station->Notify(notice);
  };
  options.on_tick = [&console, &device,
                     fault = DeviceFault::kNone](const TickRecord& tick) mutable {
    if (std::exchange(fault, tick.device.fault) == tick.device.fault) return;
    const std::string words = FaultInWords(tick.device);
    console.Print("device " + device->description() + ": " +
                  (words.empty() ? "good readings"
                                 : words + "; its force is zero. " +
                                       std::string(NextStepOf(tick.device.fault))));
  };
  if (station) {
    console.Print("view at " + station->address());
    options.on_tick = [&station, print = options.on_tick](const TickRecord& tick) {
      print(tick);
      station->OnTick(tick);
    };
  }
  std::optional<Keys> keys;
  keys.emplace(RequestEmergencyStop, [] { g_reset = true; });
  if (isatty(STDIN_FILENO) == 0) {
    console.Print(
        "the input is no terminal: Enter and r do nothing; SIGUSR1 stops the tool, SIGUSR2 resets "
        "the stop");
  }
  // The table of fingertips shows the object's deflection.
  if (console.live() && !scene.fingertips.empty()) {
    observer->Need(Observer::User::kTable, {.mesh_rate = 5});
  }
  if (recorder) recorder->AddTickObserver(&options.on_tick);
  // A reset may take seconds on a slow link, while this thread must continue to read the ticks.
  LatestValue<std::string> reset_answer;
  TaskQueue calls(kMaxResets);
  Report report = RunSession(
      options, *device, &line->states, &line->commands, [line] { return line->link.stats(); },
      [&] { return g_stop.load() || line->link.denied(); },
      [&](const SessionStatus& status) {
        // Read before the request is taken: a stop that is requested later has another number.
        const StateRecord newest = line->link.state();
        const std::uint64_t stops = newest.message ? newest.message->stops() : 0;
        if (g_reset.exchange(false)) {
          calls.Submit([&, stops](const std::stop_token&) {
            reset_answer.Put(line->link.calls().Reset(stops));
          });
        }
        if (const std::string* why = reset_answer.Take()) {
          console.Print(why->empty() ? "the emergency stop was reset"
                                     : "the slave did not reset the stop: " + *why);
        }
        console.Show(status, observer->mesh().get());
        if (station) station->Update(status);
      });
  line->link.EndCalls();
  station.reset();
  std::this_thread::sleep_for(kLastWords);
  line->link.Stop();
  const Observer::MeshStats meshes = observer->mesh_stats();
  if (meshes.meshes > 0) report.shape = ShapeReport{meshes.meshes, meshes.deflection_peak};
  observer.reset();
  const bool recorded = !recorder || recorder->Finish(&console, &report);

  report.scene = scene.name;
  report.model = scene.model;
  console.Print(FormatSummary(report));
  if (!a.report.empty()) WriteReport(report, a.report);
  const bool never_served = report.link.states == 0 && !report.link.observes && !g_stop;
  if (never_served) {
    const std::string& why = report.link.trouble;
    console.Print("failed: the slave never sent a state" + (why.empty() ? why : ": " + why));
  }
  return report.log_failed || never_served || !recorded ? EXIT_FAILURE : EXIT_SUCCESS;
}

void CatchSignals() {
  std::signal(SIGUSR1, [](int) { RequestEmergencyStop(); });
  std::signal(SIGUSR2, [](int) { g_reset = true; });
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  if (std::signal(SIGHUP, OnSignal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace palpate
