#include "master/station/live_station.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>
#include <utility>

#include "master/link/mesh_watch.h"
#include "master/link/video_watch.h"
#include "master/station/clerk.h"
#include "master/station/diary.h"
#include "master/station/display.h"
#include "master/station/hand_lead.h"
#include "master/station/notice_board.h"
#include "master/station/server/page_files.h"
#include "master/station/server/page_server.h"
#include "master/station/terminal.h"
#include "master/station/terminal_text.h"
#include "master/station/wish.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kFrame(33);
constexpr std::chrono::seconds kLookAway(2);  // nobody looks for so long: nothing is watched
constexpr double kMeshRate = 15;              // [Hz]
constexpr double kMeshError = 1e-4;           // of the object: a tenth of a pixel of a page
constexpr double kFrozen = 1;                 // a picture that is older stands still [s]
constexpr double kFrozenPeriods = 3;          // or, where the sensor is slow, of it [-]
constexpr double kTraceShown = 1;             // of a tick a while ago [s]
constexpr std::uint64_t kTerminal = 0;        // where a wish came from no page

// What the slave makes only while somebody looks.
struct Views {
  explicit Views(const SlaveLink::Options& line)
      : video(line, {}),
        meshes({.target = line.target,
                .insecure = line.insecure,
                .tls = line.tls,
                .rate = kMeshRate,
                .relative_error = kMeshError,
                .traction = true}) {}
  VideoWatch video;
  MeshWatch meshes;
};

// Nobody feels a change of scales: the hand is let go, the tool touches nothing.
bool IsFree(const StationMoment& moment) {
  const OperatorState state = moment.ticks.newest.state;
  const bool is_let_go = state == OperatorState::kReady || state == OperatorState::kClutched ||
                         state == OperatorState::kEstop;
  return is_let_go && !moment.felt.state.local_model.in_contact &&
         std::ranges::none_of(moment.status.fingers,
                              [](const NamedFinger& finger) { return finger.felt.in_contact; });
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
      : options(std::move(chosen)), controls(std::move(given)), news(options.line) {
    StationHello hello = options.hello;
    hello.libraries = FindPageFile("/lib/three.module.js") && FindPageFile("/lib/uPlot.esm.js");
    board.Put(Topic::kHello, HelloJson(hello));
  }

  void Run(const std::stop_token& stop);
  // Watches pictures and shapes while a page is open.
  void LookOrLookAway();
  void PutMoment();
  // Of the newest tick whose sample's trace has come.
  std::optional<HandTrace> TraceNow(const TickDigest::Moment& moment);
  void PutTerminal(const StationMoment& moment);
  // How long it has stood still [s]; 0: it goes on, or none came.
  double PutPicture(const TickDigest::Moment& ticks);
  void PutShape(const TickDigest::Moment& ticks);
  void PutHealth();
  // When the slave sensed, on the session's clock [s].
  [[nodiscard]] double SinceBegin(const TickDigest::Moment& ticks, Time sensed_at) const;

  // What a page or, kTerminal, a key asks for; the answer.
  std::string Do(std::uint64_t page, const Wish& asked);
  void Strike(char key);
  void Left(std::uint64_t page);
  // Empty, or what to answer.
  std::string Point(std::uint64_t page, const PointerWish& wish);
  std::string Record(const RecordWish& wish);
  void Reset();
  void ReinitializeTracking();
  // A lower limit counts at once. What changes force or place waits until nobody feels it.
  void Set(const MappingWish& wish);
  void SetWhenFree(const StationMoment& moment);
  void Replace(const ModelWish& wish);
  std::string Examine();
  // Lets the clerk do `errand`, which says what became of it.
  void Errand(std::function<void()> errand);
  void Say(bool is_trouble, std::string text);

  const Options options;
  const Controls controls;
  NoticeBoard board;
  TickDigest ticks;
  Diary diary;
  SlaveNews news;
  mutable std::mutex mutex;  // guards these three
  Status status;
  StationMoment on_screen;
  SlaveLink::Mapping waiting;
  HandLead lead;  // the server's thread
  // What the editor alone uses.
  std::unique_ptr<Views> views;
  std::chrono::steady_clock::time_point looked{};
  std::uint64_t picture = 0, health = 0, shape = 0;
  std::optional<HandTrace> trace;
  std::vector<Saying> said;
  std::vector<std::string> slave_alarms;
  std::string health_trouble;
  bool told_to_wait = false;  // what waits now
  Display display{&board};

  std::atomic<bool> examines{false};
  Clerk clerk, doctor;
  std::unique_ptr<PageServer> server;  // null: no page
  std::unique_ptr<Terminal> terminal;  // null: no terminal
  std::jthread editor;                 // last: it uses all of the above
};

void LiveStation::Parts::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    LookOrLookAway();
    PutMoment();
    if (server) server->Tell();
    std::this_thread::sleep_for(kFrame);
  }
}

void LiveStation::Parts::LookOrLookAway() {
  const auto now = std::chrono::steady_clock::now();
  if (server && server->pages() > 0) looked = now;
  const bool somebody_looks = now - looked < kLookAway;
  if (somebody_looks && !views) {
    views = std::make_unique<Views>(options.line);
    picture = shape = 0;
  }
  if (!somebody_looks) views.reset();
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
  moment.felt = news.felt();
  if (moment.felt.state.sequence > 0) {
    moment.felt_age = SecondsBetween(moment.felt.received_at, Clock::now());
  }
  SetWhenFree(moment);
  moment.trace = TraceNow(moment.ticks);
  diary.See(moment.ticks.t, news.TakeEvents());
  if (controls.recording) moment.recording = controls.recording();
  if (options.pointer != nullptr) {
    moment.pointer_holds = options.pointer->holds();
    moment.pointer_used = options.pointer->used();
  }
  if (views) {
    moment.video_trouble = views->video.trouble();
    moment.mesh_trouble = views->meshes.stats().trouble;
    moment.picture_stands = PutPicture(moment.ticks);
    PutShape(moment.ticks);
  }
  PutHealth();
  moment.slave_alarms = slave_alarms;
  moment.health_trouble = health_trouble;
  moment.other_release = OtherRelease(options.hello.scene.version, options.hello.version);
  if (const auto sayings = diary.TakeNews()) {
    said = *sayings;
    board.Put(Topic::kSaid, SaidJson(said));
  }
  LeaveOutOld(&moment);
  board.Put(Topic::kStatus, StatusJson(moment));
  if (terminal) PutTerminal(moment);
}

std::optional<HandTrace> LiveStation::Parts::TraceNow(const TickDigest::Moment& moment) {
  const auto sample = news.TraceOf(moment.newest.sensed_at);
  const auto newest = sample ? TraceOf(moment.newest, moment.t, *sample) : std::nullopt;
  if (newest) trace = newest;
  if (trace && moment.t - trace->t > kTraceShown) trace.reset();
  return trace;
}

void LiveStation::Parts::PutTerminal(const StationMoment& moment) {
  const Terminal::Size size = terminal->size();
  terminal->Show(
      TerminalText(options.hello, moment, said, {size.columns, size.rows, terminal->has_colour()}));
  const std::scoped_lock lock(mutex);
  on_screen = moment;
}

void LiveStation::Parts::Strike(char key) {
  std::optional<Wish> wish;
  {
    const std::scoped_lock lock(mutex);
    wish = WishOfKey(key, on_screen);
  }
  if (!wish) return controls.quit();
  const std::string refused = Do(kTerminal, *wish);
  if (!refused.empty()) Say(true, "not done: connect --record FILE.mcap");
}

double LiveStation::Parts::SinceBegin(const TickDigest::Moment& moment, Time sensed_at) const {
  const std::scoped_lock lock(mutex);
  return SecondsBetween(moment.begin, sensed_at - Seconds(status.link.clock_offset));
}

double LiveStation::Parts::PutPicture(const TickDigest::Moment& moment) {
  const auto newest = views->video.newest();
  if (!newest) return 0;
  const double sensed_at = SinceBegin(moment, newest->sensed_at);
  if (newest->number != picture) display.PutPicture(newest->jpeg, sensed_at);
  picture = newest->number;
  const double age = moment.t - sensed_at, rate = options.hello.scene.sensor_rate;
  return age > std::max(kFrozen, kFrozenPeriods / rate) ? age : 0;
}

void LiveStation::Parts::PutShape(const TickDigest::Moment& moment) {
  const auto mesh = views->meshes.newest();
  if (!mesh || mesh->sequence == shape) return;
  shape = mesh->sequence;
  display.PutShape(*mesh, SinceBegin(moment, mesh->sensed_at));
}

void LiveStation::Parts::PutHealth() {
  const SlaveNews::Words words = news.words();
  if (words.version == health) return;
  health = words.version;
  slave_alarms = AlarmsIn(words);
  health_trouble = words.trouble;
  board.Put(Topic::kHealth, HealthJson(words));
}

std::string LiveStation::Parts::Do(std::uint64_t page, const Wish& asked) {
  std::string answer;
  std::visit(Match{[&](const StopWish&) {
                     controls.stop();
                     Say(true, page == kTerminal ? "emergency stop by the terminal"
                                                 : "emergency stop by the page");
                   },
                   [&](const ResetWish&) { Reset(); },
                   [&](const PingWish& wish) { answer = PongJson(wish.at); },
                   [&](const PastWish&) { answer = PastJson(ticks.Past()); },
                   [&](const PointerWish& wish) { answer = Point(page, wish); },
                   [&](const MappingWish& wish) { Set(wish); },
                   [&](const ModelWish& wish) { Replace(wish); },
                   [&](const MarkWish&) { ++options.wishes->marks; },
                   [&](const TareWish&) { ++options.wishes->tares; },
                   [&](const FindWish&) { ReinitializeTracking(); },
                   [&](const ExamineWish&) { answer = Examine(); },
                   [&](const ClutchWish& wish) { options.wishes->clutched = wish.on; },
                   [&](const RenderWish& wish) { options.wishes->render = wish.mode; },
                   [&](const RecordWish& wish) { answer = Record(wish); },
                   [&](const ReplayWish&) { answer = RefusedJson("this is no replay"); }},
             asked);
  return answer;
}

std::string LiveStation::Parts::Point(std::uint64_t page, const PointerWish& wish) {
  if (options.pointer == nullptr) return RefusedJson("the device is no pointer: --device pointer");
  const Time now = Clock::now();
  if (lead.Hears(page, wish.engaged, now)) {
    options.pointer->Aim({wish.p_M, page, wish.engaged, now, wish.at});
  } else if (wish.engaged) {
    return LedElsewhereJson();
  }
  return {};
}

void LiveStation::Parts::Left(std::uint64_t page) {
  if (lead.Leaves(page)) options.pointer->Aim({});
}

std::string LiveStation::Parts::Record(const RecordWish& wish) {
  if (!controls.record) return RefusedJson("nothing is recorded: connect --record FILE.mcap");
  controls.record(wish.on);
  Say(false, wish.on ? "recording goes on" : "recording is off");
  return {};
}

void LiveStation::Parts::Reset() {
  Errand([this] {
    const bool done = controls.reset();
    Say(!done, done ? "the emergency stop was reset" : "the slave did not reset: try again");
  });
}

void LiveStation::Parts::ReinitializeTracking() {
  Errand([this] {
    const std::string why = controls.reinitialize_tracking();
    Say(!why.empty(),
        why.empty() ? "tip, template and rest are found anew" : "not found anew: " + why);
  });
}

void LiveStation::Parts::Set(const MappingWish& wish) {
  const std::scoped_lock lock(mutex);
  if (wish.position_scale) waiting.position_scale = wish.position_scale;
  if (wish.force_scale) waiting.force_scale = wish.force_scale;
  if (!wish.force_limit) return;
  if (*wish.force_limit > status.force_limit) {
    return Say(true, Formatted("the limit stays at %g N: it is only lowered while a session runs; "
                               "a higher one is --force-limit at the next start",
                               status.force_limit));
  }
  options.wishes->force_limit = *wish.force_limit;
  waiting.force_limit = wish.force_limit;
}

void LiveStation::Parts::SetWhenFree(const StationMoment& moment) {
  const SlaveLink::Mapping& seen = moment.waiting;
  const bool waits = seen.position_scale || seen.force_scale || seen.force_limit;
  const bool was_told = std::exchange(told_to_wait, waits && !IsFree(moment));
  if (told_to_wait && !was_told) {
    Say(false, "scales and limit wait until the hand is let go and nothing is touched");
  }
  if (!waits || told_to_wait) return;
  SlaveLink::Mapping asked;
  {
    const std::scoped_lock lock(mutex);
    std::swap(asked, waiting);
  }
  Errand([this, asked] {
    const std::string why = controls.set_mapping(asked);
    Say(!why.empty(), why.empty() ? "scales and limit were set" : "not set: " + why);
  });
}

std::string LiveStation::Parts::Examine() {
  if (examines.exchange(true)) return RefusedJson("the doctor examines already: wait for it");
  board.Put(Topic::kFindings, FindingsJson({}, false));
  doctor.Ask([this](const std::stop_token& stop) {
    board.Put(Topic::kFindings, FindingsJson(controls.examine(stop), true));
    examines = false;
  });
  return {};
}

void LiveStation::Parts::Replace(const ModelWish& wish) {
  Say(false, "the slave makes the model " + wish.kind);
  Errand([this, kind = wish.kind] {
    const std::string why = controls.set_model(kind);
    Say(!why.empty(), why.empty() ? "the model is " + kind : "the model stays: " + why);
  });
}

void LiveStation::Parts::Errand(std::function<void()> errand) {
  const auto asked = [errand = std::move(errand)](const std::stop_token&) { errand(); };
  if (!clerk.Ask(asked)) Say(true, "too much at once: wait until it is done");
}

void LiveStation::Parts::Say(bool is_trouble, std::string text) {
  diary.Say(ticks.Newest().t, is_trouble, std::move(text));
}

LiveStation::LiveStation(Options options, Controls controls)
    : parts_(std::make_unique<Parts>(std::move(options), std::move(controls))) {
  Parts* parts = parts_.get();
  if (parts->options.at) {
    parts->server = std::make_unique<PageServer>(
        parts->options.at->endpoint, &parts->board,
        PageServer::Listener{[parts](std::uint64_t page, std::string_view said) {
                               return parts->Do(page, ReadWish(said));
                             },
                             [parts](std::uint64_t page) { parts->Left(page); }},
        parts->options.at->access);
  }
  if (parts->options.terminal) {
    parts->terminal = std::make_unique<Terminal>([parts](char key) { parts->Strike(key); });
  }
  parts->editor = std::jthread([parts](const std::stop_token& stop) { parts->Run(stop); });
}

LiveStation::~LiveStation() = default;

std::string LiveStation::address() const {
  return parts_->server ? parts_->server->address() : std::string();
}

void LiveStation::SeeTick(const TickRecord& tick) {
  parts_->diary.See(parts_->ticks.Add(tick), tick);
}

void LiveStation::See(const Status& status) {
  const std::scoped_lock lock(parts_->mutex);
  parts_->status = status;
}

}  // namespace palpate
