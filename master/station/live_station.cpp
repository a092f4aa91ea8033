#include "master/station/live_station.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "master/station/display.h"
#include "master/station/event_log.h"
#include "master/station/pointer_control_lock.h"
#include "master/station/server/notice_board.h"
#include "master/station/server/page_command.h"
#include "master/station/server/page_files.h"
#include "master/station/server/page_server.h"
#include "shared/link/task_queue.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kMomentPeriod(33);
constexpr std::chrono::seconds kCloseStreamsAfter(2);  // time without a page
// A mesh error of 1e-4 of the object is a tenth of a pixel of a page.
constexpr ObservedViews kPageViews{.image_rate = 15, .mesh_rate = 15, .traction = true};
constexpr double kFrozen = 1;         // an older image is frozen [s]
constexpr double kFrozenPeriods = 3;  // the same in sensor periods, for slow sensors [-]
constexpr std::size_t kMaxTasks = 4;  // requests of the page that wait for the slave
constexpr double kTraceShown = 1;     // age of the tick whose trace is shown [s]

// Streams of the slave while a page is open, and the last shown message of each.
struct PageViews {
  // `is_open`: a page is open now. `field`: one shows the displacement field.
  void Update(bool is_open, bool field, Observer* observer) {
    const auto now = std::chrono::steady_clock::now();
    if (is_open) opened = now;
    streams = now - opened < kCloseStreamsAfter;
    ObservedViews views = streams ? kPageViews : ObservedViews();
    views.field = streams && field;
    if (std::exchange(needed, views) != views) observer->Need(Observer::User::kPage, views);
  }

  bool streams = false;
  ObservedViews needed;
  std::chrono::steady_clock::time_point opened{};
  std::uint64_t image = 0, shape = 0;
};

// The last shown health of the slave.
struct ShownHealth {
  std::uint64_t version = 0;
  std::vector<std::string> alarms;
  std::string trouble;
};

// Returns whether scales may change: the operator is disengaged and nothing is touched.
bool IsFree(const StationMoment& moment) {
  const OperatorState state = moment.ticks.newest.state;
  const bool is_let_go = state == OperatorState::kReady || state == OperatorState::kClutched ||
                         state == OperatorState::kEstop;
  return is_let_go && !moment.slave_state.local_model().in_contact() &&
         std::ranges::none_of(moment.status.fingers,
                              [](const NamedFinger& finger) { return finger.contact.in_contact; });
}

template <class... Cases>
struct Match : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Match(Cases...) -> Match<Cases...>;

}  // namespace

struct LiveStation::Parts {
  Parts(Options chosen, Controls given)
      : options(std::move(chosen)),
        controls(std::move(given)),
        observer(*options.observer),
        hello(options.hello) {
    hello.libraries = FindPageFile("/lib/three.module.js") && FindPageFile("/lib/uPlot.esm.js");
    board.Put(Topic::kHello, HelloJson(hello));
  }

  void Run(const std::stop_token& stop);
  void PutMoment();
  // Returns the trace of the newest tick whose sample trace has arrived.
  std::optional<HandTrace> TraceNow(const TickDigest::Moment& moment);
  // Time since the image is frozen [s]; 0: not frozen, or no image.
  double PutImage(const TickDigest::Moment& ticks);
  void PutShape(const TickDigest::Moment& ticks);
  void PutHealth();
  // Shows another scene that the slave uses after a set-up.
  void TakeScene(const RemoteScene& scene);
  // Returns the sample time on the session's clock [s].
  [[nodiscard]] double SinceBegin(const TickDigest::Moment& ticks, Time sensed_at) const;

  // Executes a command of a page. Returns the answer.
  std::string Do(std::uint64_t page, const PageCommand& asked);
  void OnPageLeft(std::uint64_t page);
  // Sets whether `page` shows the displacement field.
  void ShowField(std::uint64_t page, bool on);
  // Returns the answer; empty: there is none.
  std::string Point(std::uint64_t page, const PointerCommand& command);
  std::string Record(const RecordCommand& command);
  void Reset();
  void ReinitializeTracking();
  // A lower limit acts at once. Scales wait until IsFree.
  void Set(const MappingCommand& command);
  void SetWhenFree(const StationMoment& moment);
  void Replace(const ModelCommand& command);
  void SetUp(const std::string& call, std::string json, PageServer::Listener::Done done);
  // Queues `task`, which logs its outcome.
  void SubmitTask(std::function<void()> task);
  void Log(bool is_trouble, std::string text);

  const Options options;
  const Controls controls;
  Observer& observer;
  NoticeBoard board;
  TickDigest ticks;
  EventLog event_log;
  mutable std::mutex mutex;  // guards the next two members
  SessionStatus status;
  SlaveLink::Mapping waiting;
  // Used by the server's thread.
  PointerControlLock lead;
  std::set<std::uint64_t> field_pages;   // pages that show the field
  std::atomic<bool> shows_field{false};  // whether one of them shows it
  // Only the editor uses the members below.
  StationHello hello;
  PageViews page_views;
  ShownHealth health;
  std::optional<HandTrace> trace;
  std::vector<LogEntry> log;
  bool is_waiting = false;  // whether a setting waits now
  Display display{&board};

  TaskQueue tasks{kMaxTasks};
  std::unique_ptr<PageServer> server;
  TaskQueue setup_calls{kMaxTasks};  // answers through the server
  std::jthread editor;               // last: it uses all of the above
};

void LiveStation::Parts::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    page_views.Update(server->pages() > 0, shows_field, &observer);
    PutMoment();
    server->Notify();
    std::this_thread::sleep_for(kMomentPeriod);
  }
}

void LiveStation::Parts::PutMoment() {
  StationMoment moment;
  moment.ticks = ticks.Newest();
  if (!moment.ticks.any) return;
  {
    const std::scoped_lock lock(mutex);
    moment.status = status;
    moment.waiting = waiting;
  }
  if (const StateRecord newest = controls.state(); newest.message) {
    moment.slave_state = *newest.message;
    moment.slave_state_age = SecondsBetween(newest.received_at, Clock::now());
  }
  SetWhenFree(moment);
  moment.trace = TraceNow(moment.ticks);
  event_log.AppendEvents(moment.ticks.t, controls.take_events());
  if (controls.recording) moment.recording = controls.recording();
  if (options.pointer != nullptr) {
    moment.pointer_holds = options.pointer->holds();
    moment.pointer_used = options.pointer->used();
    moment.pointer_silence = options.pointer->silence();
  }
  if (page_views.streams) {
    moment.video_trouble = observer.image_trouble();
    moment.mesh_trouble = observer.mesh_stats().trouble;
    moment.frozen_for = PutImage(moment.ticks);
    PutShape(moment.ticks);
  }
  PutHealth();
  moment.slave_alarms = health.alarms;
  moment.health_trouble = health.trouble;
  moment.other_release = OtherRelease(hello.scene.version, hello.version);
  if (const auto entries = event_log.TakeNew()) {
    log = *entries;
    board.Put(Topic::kLog, LogJson(log));
  }
  LeaveOutOld(&moment);
  board.Put(Topic::kStatus, StatusJson(moment));
}

std::optional<HandTrace> LiveStation::Parts::TraceNow(const TickDigest::Moment& moment) {
  const auto sample = observer.TraceOf(moment.newest.sensed_at);
  const auto newest = sample ? TraceOf(moment.newest, moment.t, *sample) : std::nullopt;
  if (newest) trace = newest;
  if (trace && moment.t - trace->t > kTraceShown) trace.reset();
  return trace;
}

double LiveStation::Parts::SinceBegin(const TickDigest::Moment& moment, Time sensed_at) const {
  const std::scoped_lock lock(mutex);
  return SecondsBetween(moment.begin, sensed_at - Seconds(status.link.clock_offset));
}

double LiveStation::Parts::PutImage(const TickDigest::Moment& moment) {
  const auto newest = observer.image();
  if (!newest) return 0;
  const double sensed_at = SinceBegin(moment, newest->sensed_at);
  if (newest->number != page_views.image) display.PutImage(newest->jpeg, sensed_at);
  page_views.image = newest->number;
  const double age = moment.t - sensed_at, rate = hello.scene.sensor_rate;  // 0: unknown
  return age > std::max(kFrozen, rate > 0 ? kFrozenPeriods / rate : 0) ? age : 0;
}

void LiveStation::Parts::PutShape(const TickDigest::Moment& moment) {
  const auto mesh = observer.mesh();
  if (!mesh || mesh->sequence == page_views.shape) return;
  page_views.shape = mesh->sequence;
  display.PutShape(*mesh, SinceBegin(moment, mesh->sensed_at));
}

void LiveStation::Parts::PutHealth() {
  const SlaveHealth newest = observer.health();
  if (newest.version == health.version) return;
  health = {newest.version, AlarmsIn(newest), newest.trouble};
  if (newest.remote) TakeScene(*newest.remote);
  board.Put(Topic::kHealth, HealthJson(newest));
}

// Changed settings of the same scene are no other scene: the page's sliders are relative to those
// of the start.
void LiveStation::Parts::TakeScene(const RemoteScene& scene) {
  const RemoteScene& shown = hello.scene;
  const bool is_other = scene.name != shown.name || scene.geometry != shown.geometry ||
                        scene.sensor_rate != shown.sensor_rate;
  if (!scene.accepts_setup || !is_other) return;
  hello.scene = scene;
  board.Put(Topic::kHello, HelloJson(hello));
}

std::string LiveStation::Parts::Do(std::uint64_t page, const PageCommand& asked) {
  std::string answer;
  std::visit(Match{[&](const StopCommand&) {
                     controls.stop();
                     Log(true, "emergency stop from the page");
                   },
                   [&](const ResetCommand&) { Reset(); },
                   [&](const PingCommand& command) { answer = PongJson(command.at); },
                   [&](const PastCommand&) { answer = PastJson(ticks.Past()); },
                   [&](const PointerCommand& command) { answer = Point(page, command); },
                   [&](const MappingCommand& command) { Set(command); },
                   [&](const ModelCommand& command) { Replace(command); },
                   [&](const MarkCommand&) { ++options.requests->marks; },
                   [&](const TareCommand&) { ++options.requests->tares; },
                   [&](const ReinitializeTrackingCommand&) { ReinitializeTracking(); },
                   [&](const ClutchCommand& command) { options.requests->clutched = command.on; },
                   [&](const RenderCommand& command) { options.requests->render = command.mode; },
                   [&](const RecordCommand& command) { answer = Record(command); },
                   [&](const FieldCommand& command) { ShowField(page, command.on); },
                   [&](const ReplayCommand&) { answer = RefusedJson("this is not a replay"); }},
             asked);
  return answer;
}

std::string LiveStation::Parts::Point(std::uint64_t page, const PointerCommand& command) {
  if (options.pointer == nullptr)
    return RefusedJson("the device is not a pointer: connect --device pointer");
  const Time now = Clock::now();
  if (lead.Hears(page, command.engaged, now, Pointer::MaxSilence(command.gap))) {
    options.pointer->Aim({command.p_M, page, command.engaged, now, command.at, command.gap});
  } else if (command.engaged) {
    return LedElsewhereJson();
  }
  return {};
}

void LiveStation::Parts::ShowField(std::uint64_t page, bool on) {
  if (on) {
    field_pages.insert(page);
  } else {
    field_pages.erase(page);
  }
  shows_field = !field_pages.empty();
}

void LiveStation::Parts::OnPageLeft(std::uint64_t page) {
  ShowField(page, false);
  if (lead.Leaves(page)) options.pointer->Aim({});
}

std::string LiveStation::Parts::Record(const RecordCommand& command) {
  if (!controls.record) return RefusedJson("nothing is recorded: connect --record FILE.mcap");
  controls.record(command.on);
  Log(false, command.on ? "recording is on" : "recording is off");
  return {};
}

// The slave rejects the reset if there was a stop that this station does not know.
void LiveStation::Parts::Reset() {
  const StateRecord newest = controls.state();
  SubmitTask([this, stops = newest.message ? newest.message->stops() : 0] {
    const std::string why = controls.reset(stops);
    Log(!why.empty(),
        why.empty() ? "the emergency stop was reset" : "the slave did not reset the stop: " + why);
  });
}

void LiveStation::Parts::ReinitializeTracking() {
  SubmitTask([this] {
    const std::string why = controls.reinitialize_tracking();
    Log(!why.empty(),
        why.empty() ? "tracking is reinitialized" : "tracking is not reinitialized: " + why);
  });
}

void LiveStation::Parts::Set(const MappingCommand& command) {
  const std::scoped_lock lock(mutex);
  if (command.position_scale) waiting.position_scale = command.position_scale;
  if (command.force_scale) waiting.force_scale = command.force_scale;
  if (!command.force_limit) return;
  if (*command.force_limit > status.force_limit) {
    return Log(true,
               Formatted("the limit stays at %g N: a session can only lower it; for a higher limit "
                         "restart with --force-limit",
                         status.force_limit));
  }
  options.requests->force_limit = *command.force_limit;
  waiting.force_limit = command.force_limit;
}

void LiveStation::Parts::SetWhenFree(const StationMoment& moment) {
  const SlaveLink::Mapping& seen = moment.waiting;
  const bool waits = seen.position_scale || seen.force_scale || seen.force_limit;
  const bool was_waiting = std::exchange(is_waiting, waits && !IsFree(moment));
  if (is_waiting && !was_waiting) {
    Log(false, "scales and limit wait until the operator is disengaged and nothing is touched");
  }
  if (!waits || is_waiting) return;
  SlaveLink::Mapping asked;
  {
    const std::scoped_lock lock(mutex);
    std::swap(asked, waiting);
  }
  SubmitTask([this, asked] {
    const std::string why = controls.set_mapping(asked);
    Log(!why.empty(),
        why.empty() ? "scales and limit are set" : "scales and limit are not set: " + why);
  });
}

void LiveStation::Parts::Replace(const ModelCommand& command) {
  Log(false, "the slave builds the model " + command.kind);
  SubmitTask([this, kind = command.kind] {
    const std::string why = controls.set_model(kind);
    Log(!why.empty(), why.empty() ? "the model is " + kind : "the model is unchanged: " + why);
  });
}

void LiveStation::Parts::SetUp(const std::string& call, std::string json,
                               PageServer::Listener::Done done) {
  const bool is_queued =
      setup_calls.Submit([this, call, json = std::move(json), done](const std::stop_token& stop) {
        SetupCalls::Answer answer = controls.set_up(call, json, stop);
        if (call == "use" && answer.status == 200)
          Log(false, "the slave uses the scene of the page");
        done(answer.status, std::move(answer.json));
      });
  if (!is_queued) done(503, SetupErrorJson("too many requests: wait until they are done"));
}

void LiveStation::Parts::SubmitTask(std::function<void()> task) {
  const auto asked = [task = std::move(task)](const std::stop_token&) { task(); };
  if (!tasks.Submit(asked)) Log(true, "too many requests: wait until they are done");
}

void LiveStation::Parts::Log(bool is_trouble, std::string text) {
  event_log.Append(ticks.Newest().t, is_trouble, std::move(text));
}

LiveStation::LiveStation(Options options, Controls controls)
    : parts_(std::make_unique<Parts>(std::move(options), std::move(controls))) {
  Parts* parts = parts_.get();
  parts->server = std::make_unique<PageServer>(
      parts->options.at.endpoint, &parts->board,
      PageServer::Listener{
          [parts](std::uint64_t page, std::string_view message) {
            return parts->Do(page, ReadPageCommand(message));
          },
          [parts](std::uint64_t page) { parts->OnPageLeft(page); },
          [parts](const std::string& call, std::string json, PageServer::Listener::Done done) {
            parts->SetUp(call, std::move(json), std::move(done));
          }},
      parts->options.at.access);
  parts->editor = std::jthread([parts](const std::stop_token& stop) { parts->Run(stop); });
}

LiveStation::~LiveStation() = default;

std::string LiveStation::address() const {
  return parts_->server->address();
}

void LiveStation::OnTick(const TickRecord& tick) {
  parts_->event_log.AppendChanges(parts_->ticks.Add(tick), tick);
}

void LiveStation::Notify(const std::string& notice) {
  parts_->Log(true, notice);
}

void LiveStation::Update(const SessionStatus& status) {
  const std::scoped_lock lock(parts_->mutex);
  parts_->status = status;
}

}  // namespace palpate
