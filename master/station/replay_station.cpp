#include "master/station/replay_station.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "palpate/v1/teleoperation.pb.h"

#include "master/link/observer.h"
#include "master/link/remote_scene.h"
#include "master/recording/replay.h"
#include "master/station/display.h"
#include "master/station/moment_json.h"
#include "master/station/server/page_command.h"
#include "master/station/server/page_files.h"
#include "master/station/server/page_server.h"
#include "master/station/tick_digest.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::ptrdiff_t kSayingsShown = 50;

template <class Message>
std::optional<Message> NewestBy(double t, const std::map<double, Message>& messages) {
  const auto after = messages.upper_bound(t);
  return after == messages.begin() ? std::nullopt : std::optional(std::prev(after)->second);
}

// Rarely changing data of a recording, read before the replay: scene and status of the slave,
// and the log.
class ReplayScene {
 public:
  // Reads the whole recording. Throws InputError if a message is damaged.
  ReplayScene(const Replay& replay, const std::string& file) {
    const auto since = [&](Time at) { return SecondsBetween(replay.span().first, at); };
    ReplayFeed feed;
    feed.on_scene = [&](const v1::SceneDescription& sent, Time at) { scenes_[since(at)] = sent; };
    feed.on_health = [&](const v1::Status& sent, Time at) { health_[since(at)] = sent; };
    feed.on_log = [&](const std::string& line, Time at, bool is_alarm) {
      entries_.push_back({entries_.size() + 1, since(at), is_alarm, line});
    };
    replay.Play(0, 0, feed, {});
    if (!scenes_.empty()) hello_.scene = ToRemoteScene(scenes_.begin()->second);
    hello_.badge = "REPLAY";
    hello_.target = file;
    TakeNote(replay.span().session);
  }

  [[nodiscard]] const StationHello& hello() const { return hello_; }
  // A text if another build than `own` recorded it; empty if it is the same or unknown.
  [[nodiscard]] std::string OtherBuild(const std::string& own) const {
    if (hello_.version.empty() || own.empty() || hello_.version == own) return {};
    return "Recorded by palpate-master " + hello_.version + ", played by " + own + ".";
  }
  // Messages of the slave up to `t` [s].
  [[nodiscard]] SlaveHealth HealthAt(double t) const {
    return {.scene = NewestBy(t, scenes_), .status = NewestBy(t, health_)};
  }
  // The newest log entries up to `t` [s], newest last.
  [[nodiscard]] std::vector<LogEntry> EntriesBy(double t) const {
    const auto end = std::ranges::upper_bound(entries_, t, {}, &LogEntry::t);
    return {end - std::min(kSayingsShown, end - entries_.begin()), end};
  }

 private:
  void TakeNote(const McapMap& session) {
    constexpr std::size_t kMaxNoteLength = 200;
    const auto take = [&](const char* key, std::string* value) {
      const auto found = session.find(key);
      if (found != session.end()) *value = Presentable(found->second, kMaxNoteLength);
    };
    std::string limit;
    take("scene", &hello_.scene.name);
    take("device", &hello_.device);
    take("render", &hello_.render);
    take("version", &hello_.version);
    take("force_limit_N", &limit);
    hello_.scene.force_limit = ParseFinite(limit).value_or(hello_.scene.force_limit);
  }

  StationHello hello_;
  std::map<double, v1::SceneDescription> scenes_;  // by time [s]
  std::map<double, v1::Status> health_;            // by time [s]
  std::vector<LogEntry> entries_;
};

constexpr auto kFrame = std::chrono::milliseconds(33),
               kPausedFrame = std::chrono::milliseconds(100);
constexpr double kBefore =
    10;  // time before a jump target that is read for image, shape and charts [s]
constexpr double kMinPlayed = 0.02;  // time that is played at a jump even while paused [s]
constexpr double kHealthEvery = 1;   // [s]
constexpr std::size_t kUntraced = 256;

// Requested position and speed.
struct Course {
  bool playing = true;
  double speed = 1;
  std::optional<double> sought;  // [s]
};

}  // namespace

struct ReplayStation::Parts {
  Parts(const Replay* played, const Options& options)
      : replay(*played),
        scene(replay, options.file),
        length(replay.span().seconds()),
        course{true, options.speed, options.from},
        feed(Feed()) {
    StationHello hello = scene.hello();
    hello.libraries = FindPageFile("/lib/three.module.js") && FindPageFile("/lib/uPlot.esm.js");
    board.Put(Topic::kHello, HelloJson(hello));
    moment.status.force_limit = hello.scene.force_limit;
    moment.replay.emplace().seconds = length;
    moment.other_release = scene.OtherBuild(options.version);
    for (const auto& tip : hello.scene.fingertips) finger_names.push_back(tip.name);
  }

  ReplayFeed Feed();
  void Update(const TickRecord& tick);
  void Update(const SlaveState& state, const v1::SlaveState& message);
  void Update(const SampleTrace& trace);
  // Returns the sample time since the beginning of the recording [s].
  [[nodiscard]] double Since(Time sensed_at) const;
  // Processes a request of a page and returns the answer.
  std::string Receive(std::string_view message);

  // Jumps to `t`, shows the data there and forgets earlier data.
  void Cut(double t);
  // Plays from the current position until the page requests a change, or to the end.
  void Play(double speed, const std::stop_token& stop);
  bool GoesOn(double t);
  void Put();
  Course Take();
  void WaitStill(const std::stop_token& stop);

  const Replay& replay;
  const ReplayScene scene;
  const double length;  // [s]
  NoticeBoard board;
  Display display{&board};
  TickDigest ticks;
  StationMoment moment;
  std::vector<std::string> finger_names;
  // Stamps of the newest states, by their numbers.
  struct StateStamp {
    Time sensed_at, sent_at;
    Eigen::Vector3d p_S_tip;
  };
  std::map<std::uint64_t, StateStamp> stamps;
  // First tick of each sample, until its trace arrives.
  std::map<Time, std::pair<TickRecord, double>> untraced;
  double health_sent_at = -1;         // [s]
  double at = 0;                      // [s]
  std::atomic<std::uint64_t> run{0};  // rises with each cut
  std::chrono::steady_clock::time_point put{};

  std::mutex mutex;  // guards the members below
  std::condition_variable_any changed;
  Course course;
  bool is_wanted = true;  // the course changed

  const ReplayFeed feed;
  std::unique_ptr<PageServer> server;  // last: it uses all of the above
};

ReplayFeed ReplayStation::Parts::Feed() {
  ReplayFeed consumer;
  consumer.on_tick = [this](const TickRecord& tick) { Update(tick); };
  consumer.on_state = [this](const SlaveState& state, const v1::SlaveState& message) {
    Update(state, message);
  };
  consumer.on_image = [this](const std::string& jpeg, Time sensed_at) {
    display.PutImage(jpeg, Since(sensed_at));
  };
  consumer.on_trace = [this](const SampleTrace& trace) { Update(trace); };
  consumer.on_mesh = [this](const auto& mesh) { display.PutShape(*mesh, Since(mesh->sensed_at)); };
  consumer.goes_on = [this](double t) { return GoesOn(t); };
  return consumer;
}

// The offset of the clocks follows from the state's age in the tick.
void ReplayStation::Parts::Update(const TickRecord& recorded) {
  TickRecord tick = recorded;
  const auto stamp = stamps.find(tick.state_sequence);
  if (stamp != stamps.end()) {
    tick.sensed_at = stamp->second.sensed_at;
    tick.sent_at = stamp->second.sent_at;
    tick.p_S_tip = stamp->second.p_S_tip;
  }
  const double t = ticks.Add(tick);
  if (tick.sensed_at != Time{}) untraced.try_emplace(tick.sensed_at, tick, t);
  if (untraced.size() > kUntraced) untraced.erase(untraced.begin());
  moment.status.link.connected = tick.state != OperatorState::kDisconnected;
  if (tick.sensed_age < 0 || tick.state_sequence != moment.slave_state.sequence()) return;
  moment.status.link.clock_offset =
      SecondsBetween(tick.at - Seconds(tick.sensed_age), tick.sensed_at);
}

void ReplayStation::Parts::Update(const SlaveState& state, const v1::SlaveState& message) {
  moment.slave_state = message;
  stamps[state.sequence] = {state.sensed_at, state.sent_at, state.p_S_tip};
  if (stamps.size() > kUntraced) stamps.erase(stamps.begin());
  ++moment.status.link.states;
  TickRecord seen;
  RecordFingers(state, &seen);
  moment.status.fingers = Named(seen, finger_names);
}

void ReplayStation::Parts::Update(const SampleTrace& trace) {
  const auto tick = untraced.find(trace.sensed_at);
  if (tick == untraced.end()) return;
  moment.trace = TraceOf(tick->second.first, tick->second.second, trace);
  untraced.erase(untraced.begin(), std::next(tick));
}

double ReplayStation::Parts::Since(Time sensed_at) const {
  return SecondsBetween(replay.span().first, sensed_at - Seconds(moment.status.link.clock_offset));
}

std::string ReplayStation::Parts::Receive(std::string_view message) {
  const PageCommand command = ReadPageCommand(message);
  if (const auto* ping = std::get_if<PingCommand>(&command)) return PongJson(ping->at);
  if (std::holds_alternative<PastCommand>(command)) {
    // Read before the samples, so that samples of a later run are never sent as this one.
    const std::uint64_t current = run;
    return PastJson(ticks.Past(), current);
  }
  if (std::holds_alternative<FieldCommand>(command)) return {};  // recorded fields are always shown
  const auto* wanted = std::get_if<ReplayCommand>(&command);
  if (wanted == nullptr) return RefusedJson("this is a replay: nothing moves or stops a tool");
  const std::scoped_lock lock(mutex);
  if (wanted->playing) course.playing = *wanted->playing;
  if (wanted->speed) course.speed = std::clamp(*wanted->speed, Replay::kSlowest, Replay::kFastest);
  if (wanted->to) course.sought = std::clamp(*wanted->to, 0.0, length);
  is_wanted = true;
  changed.notify_all();
  return {};
}

Course ReplayStation::Parts::Take() {
  const std::scoped_lock lock(mutex);
  is_wanted = false;
  Course taken = course;
  course.sought.reset();
  return taken;
}

void ReplayStation::Parts::Cut(double t) {
  ticks.Restart(replay.span().first);
  stamps.clear();
  untraced.clear();
  moment.trace.reset();
  moment.slave_state.Clear();
  moment.status.fingers.clear();
  moment.replay->run = ++run;
  health_sent_at = -1;
  at = std::max(0.0, t - kBefore);
  ReplayFeed quick = feed;
  quick.goes_on = [&](double now) {
    at = now;
    return now < std::max(t, kMinPlayed);
  };
  replay.Play(at, 0, quick, {});
}

void ReplayStation::Parts::Play(double speed, const std::stop_token& stop) {
  replay.Play(at, speed, feed, stop);
  const std::scoped_lock lock(mutex);
  if (is_wanted || stop.stop_requested()) return;
  course.playing = false;  // stops at the end
  at = length;
}

bool ReplayStation::Parts::GoesOn(double t) {
  at = t;
  const auto now = std::chrono::steady_clock::now();
  if (now - put >= kFrame) Put();
  const std::scoped_lock lock(mutex);
  return !is_wanted;
}

void ReplayStation::Parts::Put() {
  put = std::chrono::steady_clock::now();
  moment.ticks = ticks.Newest();
  if (!moment.ticks.any) return;
  if (health_sent_at < 0 || std::abs(at - health_sent_at) >= kHealthEvery) {
    health_sent_at = at;
    const SlaveHealth health = scene.HealthAt(at);
    moment.slave_alarms = AlarmsIn(health);
    board.Put(Topic::kHealth, HealthJson(health));
    board.Put(Topic::kLog, LogJson(scene.EntriesBy(at)));
  }
  {
    const std::scoped_lock lock(mutex);
    moment.replay->playing = course.playing;
    moment.replay->speed = course.speed;
  }
  StationMoment shown = moment;
  shown.slave_state_age = shown.ticks.newest.state_age;
  LeaveOutOld(&shown);
  board.Put(Topic::kStatus, StatusJson(shown));
  server->Notify();
}

void ReplayStation::Parts::WaitStill(const std::stop_token& stop) {
  std::unique_lock lock(mutex);
  changed.wait_for(lock, stop, kPausedFrame, [this] { return is_wanted; });
}

ReplayStation::ReplayStation(const Replay* replay, const Options& options)
    : parts_(std::make_unique<Parts>(replay, options)) {
  Parts* parts = parts_.get();
  parts->server = std::make_unique<PageServer>(
      options.at.endpoint, &parts->board,
      PageServer::Listener{
          [parts](std::uint64_t, std::string_view message) { return parts->Receive(message); },
          [](std::uint64_t) {}},
      options.at.access);
}

ReplayStation::~ReplayStation() = default;

std::string ReplayStation::address() const {
  return parts_->server->address();
}

void ReplayStation::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const Course course = parts_->Take();
    if (course.sought) parts_->Cut(*course.sought);
    if (course.playing && parts_->at >= parts_->length) parts_->Cut(0);
    if (course.playing) parts_->Play(course.speed, stop);
    parts_->Put();
    parts_->WaitStill(stop);
  }
}

}  // namespace palpate
