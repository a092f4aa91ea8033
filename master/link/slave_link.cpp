#include "master/link/slave_link.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"
#include "master/link/operate_session.h"
#include "master/link/operator_calls.h"
#include "master/link/remote_scene.h"
#include "shared/link/loopback.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/link/tcp_line.h"
#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "shared/wire/errors.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry(50), kMaxRetry(500);
constexpr milliseconds kLeaseRetry(1000);
constexpr milliseconds kLostLeaseRetry(10000);  // gives another operator time to take the lease
constexpr double kObservedRate = 30;  // states of a slave that this link does not operate [Hz]
constexpr milliseconds kMaxDeadline(60000);
constexpr milliseconds kNoRefusal(500);        // a port without a listener rejects faster
constexpr milliseconds kFirstReckoned(10000);  // assumed round trip until one is known
constexpr int kTripsBorne =
    // Time limit of later calls relative to the first one, because an idle link is slow at first.
    6;
constexpr int kTimesTheFirst = 4;  // time limit relative to the time of the first answer
// Time for which a rejected state is reported, while others are accepted.
constexpr milliseconds kReportedAfterwards(3000);
// Time for the slave to end the stream after the master has finished.
constexpr milliseconds kGrace(300);

constexpr const char* kNoDatagrams = "no datagrams come through: states and commands use TCP alone";

milliseconds SinceThen(Time start) {
  return std::chrono::duration_cast<milliseconds>(Clock::now() - start);
}

LinkStats::Times TimesOf(const LatencyHistogram& times) {
  return {times.Quantile(0.5), times.Quantile(0.99), times.max()};
}

// The slave's clock by states that answer no command: the fastest one of the last 10 to 20 s counts
// as one that has travelled no time.
class ObservedClock {
 public:
  // Returns slave's minus master's clock [s].
  double Add(const SlaveState& state, Time now) noexcept {
    constexpr double kRemembered = 10;  // [s]
    newest_ = std::max(newest_, SecondsBetween(now, state.sent_at));
    const double fastest = std::max(newest_, before_);
    if (SecondsBetween(began_, now) > kRemembered) {
      before_ = std::exchange(newest_, kNone);
      began_ = now;
    }
    return fastest;
  }

 private:
  static constexpr double kNone = -std::numeric_limits<double>::infinity();
  double newest_ = kNone, before_ = kNone;
  Time began_{};
};

// Returns the time until the next attempt after a stream that ended with `reason`.
milliseconds PauseAfter(v1::ErrorReason reason, Backoff* backoff) {
  if (reason == v1::ERROR_REASON_LEASE_HELD) return kLeaseRetry;
  return reason == v1::ERROR_REASON_LEASE_LOST ? kLostLeaseRetry : backoff->Next();
}

// Returns whether a slave answered and rejected the call.
bool IsAnswer(const grpc::Status& status) {
  const auto code = status.error_code();
  return !status.ok() && code != grpc::StatusCode::UNAVAILABLE &&
         code != grpc::StatusCode::DEADLINE_EXCEEDED && code != grpc::StatusCode::CANCELLED;
}

}  // namespace

struct SlaveLink::Parts {
  explicit Parts(Options chosen)
      : options(std::move(chosen)),
        target(PermittedTarget(options.target, options.insecure || !options.tls.empty())) {
    Open(std::max(options.max_round_trip, kFirstReckoned));
  }

  // Reopens the channel, while no call is pending.
  void Open(milliseconds reckoned) {
    max_round_trip = reckoned;
    channel = OpenChannel(target, Traffic::kTicks, options.tls, max_round_trip);
    stub = v1::Teleoperation::NewStub(channel);
    calls.Use(stub.get());
  }

  // `waits`: waits for a connection within the deadline, because gRPC advances a connection only
  // while a call waits. Afterwards the time limits of calls are adapted to this link.
  grpc::Status RequestScene(RemoteScene* scene, bool waits, milliseconds deadline);
  void Run(const std::stop_token& stop, LatestValue<ReceivedState>* states,
           LatestValue<OperatorCommand>* commands);
  // Reads the settings. One call at a time. Rejects another scene than that of the first
  // connection, because the device was opened for that scene.
  grpc::Status ReadSettings();
  // Stores a state and passes it on.
  void Keep(const SlaveState& state, const StateRecord& record);
  // Reads the settings again, beside the stream, if `state` reports others.
  void Follow(const SlaveState& state);
  grpc::Status RunSession(OperateSession* session, const std::stop_token& stop);
  // Records in `status` why there is no stream, and returns it.
  grpc::Status Failed(const grpc::Status& status);
  void Served();
  void Refused(const std::string& reason);
  // Datagrams were requested, but none has arrived within the time limit; with `mutex` held.
  [[nodiscard]] bool LacksDatagrams() const;
  // Receives the states of a slave that does not serve this link, for `duration` (nullopt: no
  // limit), or until its settings change, the stream ends, or `stop`.
  void Observe(std::optional<milliseconds> duration, const std::stop_token& stop,
               LatestValue<ReceivedState>* states);
  // Observes until the stream ends or `stop`, because this link does not operate.
  void WatchAlone(const std::stop_token& stop, LatestValue<ReceivedState>* states);
  // Sleeps; returns false if a stop was requested.
  bool Sleep(milliseconds duration) {
    return SleepUntil(std::chrono::steady_clock::now() + duration);
  }
  bool SleepUntil(std::chrono::steady_clock::time_point due);
  // Waits for a connection, at most `duration`; false: stopping. gRPC advances a connection only
  // while a thread waits: after a rejected attempt a sleep would leave the next one half open.
  bool WaitForConnection(milliseconds duration);

  const Options options;
  const std::string target;
  // Answered_in: duration of a call on the open connection.
  milliseconds max_round_trip{}, answered_in{};
  std::shared_ptr<grpc::Channel> channel;         // never null
  std::unique_ptr<v1::Teleoperation::Stub> stub;  // never null
  OperatorCalls calls;                            // uses the stub
  RoundTrips trips;
  std::atomic<std::uint64_t> states_received{0}, commands_sent{0}, states_by_datagram{0};
  std::atomic<Time> datagram_at{Time{}};  // or the time from which they were possible
  std::optional<RemoteScene> first;       // scene of the first connection
  LatestValue<RemoteSettings>* settings = nullptr;
  bool operates = true;
  std::atomic<std::uint32_t> read_revision{0};
  ObservedClock observed_clock;  // of the thread that observes
  std::atomic<bool> rereads{false}, denied{false};

  mutable PriorityInheritanceMutex mutex;  // guards the members below
  PriorityInheritanceCondition changed;
  OperateSession* session = nullptr;
  bool stopping = false, was_connected = false;
  LinkStats link_stats;  // without the parts that are counted elsewhere
  std::string refusal;   // of the last state that was refused
  Clock::time_point refused_at{};
  std::string unread;  // why the settings cannot be read; empty: they can

  mutable PriorityInheritanceMutex states_mutex;  // guards the members below
  StateRecord newest;
  Events events;

  std::jthread rereading;  // the stream's thread alone starts and joins it
  std::jthread thread;     // last: it uses all of the above
};

grpc::Status SlaveLink::Parts::RequestScene(RemoteScene* scene, bool waits, milliseconds deadline) {
  const Time start = Clock::now();
  v1::SceneDescription description;
  v1::Status answer;
  grpc::ClientContext for_scene, for_status;
  SetDeadline(&for_scene, deadline);
  for_scene.set_wait_for_ready(waits);
  const OperatorCalls::Scope scene_runs(&calls, &for_scene);
  const OperatorCalls::Scope status_runs(&calls, &for_status);
  grpc::Status status = stub->GetScene(&for_scene, {}, &description);
  if (!status.ok()) return status;
  const Time connected = Clock::now();
  SetDeadline(&for_status, deadline);
  // Measures answered_in, because the connection is open now.
  status = stub->GetStatus(&for_status, {}, &answer);
  if (!status.ok()) return status;
  answered_in = SinceThen(connected);
  *scene = ToRemoteScene(description);
  calls.set_deadline(std::max(OperatorCalls::kMinDeadline, kTimesTheFirst * SinceThen(start)));
  return status;
}

grpc::Status SlaveLink::Parts::ReadSettings() {
  try {
    RemoteScene scene;
    grpc::Status status = RequestScene(&scene, true, calls.deadline());
    if (!status.ok()) return status;
    const bool is_other = first && (scene.name != first->name || scene.geometry != first->geometry);
    if (is_other && !first->accepts_setup) {
      return {grpc::StatusCode::ABORTED, "another scene is served there now, " + scene.name +
                                             " instead of " + first->name +
                                             ": restart palpate-master"};
    }
    settings->Put({scene.settings_revision, scene.transform, scene.force_limit, scene.dead_after,
                   MaxAge(scene.sensor_rate)});
    read_revision = scene.settings_revision;
    return status;
  } catch (const std::exception& error) {  // invalid numbers
    return {grpc::StatusCode::INTERNAL, error.what()};
  }
}

void SlaveLink::Parts::Keep(const SlaveState& state, const StateRecord& record) {
  {
    const std::scoped_lock lock(states_mutex);
    newest = record;
    events.Add(state.events);
  }
  if (options.on_received) options.on_received(record);
}

void SlaveLink::Parts::Follow(const SlaveState& state) {
  if (state.settings_revision == read_revision || rereads.exchange(true)) return;
  rereading = std::jthread([this] {
    const grpc::Status status = ReadSettings();
    {
      const std::scoped_lock lock(mutex);
      unread = status.ok() ? "" : "the slave's settings cannot be read: " + WordsOf(status);
    }
    if (!status.ok()) Sleep(kFirstRetry);
    rereads = false;
  });
}

void SlaveLink::Parts::Run(const std::stop_token& stop, LatestValue<ReceivedState>* states,
                           LatestValue<OperatorCommand>* commands) {
  MakeThreadRealtime(kReadingPriority);
  Backoff backoff(kFirstRetry, kMaxRetry);
  while (!stop.stop_requested()) {
    const grpc::Status read = ReadSettings();
    if (read.ok() && !operates) {
      WatchAlone(stop, states);
      if (!Sleep(backoff.Next())) return;
      continue;
    }
    for (const int line : LinesTo(ParseEndpoint(target).port)) PrepareLine(line);
    OperateSession next(
        {*stub,
         {*states, *commands, trips, states_received, states_by_datagram, [this] { Served(); },
          [this](const SlaveState& state, const StateRecord& record) {
            Follow(state);
            Keep(state, record);
          },
          [this](const std::string& reason) { Refused(reason); }},
         commands_sent,
         datagram_at,
         options.on_sent},
        options.operator_name, calls.deadline(), max_round_trip,
        {options.datagrams.value_or(!IsLoopback(ParseEndpoint(target).host)), options.details});
    const grpc::Status status = read.ok() ? RunSession(&next, stop) : Failed(read);
    if (rereading.joinable()) rereading.join();
    if (next.was_served()) backoff.Reset();
    const auto pause = PauseAfter(ReasonOf(status), &backoff);
    const auto due = std::chrono::steady_clock::now() + pause;
    if (IsAnswer(status)) {
      const bool is_unmanned = ReasonOf(status) == v1::ERROR_REASON_NO_MANIPULATOR;
      Observe(is_unmanned ? std::nullopt : std::optional(pause), stop, states);
    }
    if (!SleepUntil(due)) return;
  }
}

grpc::Status SlaveLink::Parts::RunSession(OperateSession* next, const std::stop_token& stop) {
  {
    const std::scoped_lock lock(mutex);
    if (stopping) return grpc::Status::CANCELLED;
    session = next;
  }
  grpc::Status status = Failed(next->Run(stop));
  const std::scoped_lock lock(mutex);
  session = nullptr;
  changed.notify_all();
  return status;
}

grpc::Status SlaveLink::Parts::Failed(const grpc::Status& status) {
  const std::scoped_lock lock(mutex);
  link_stats.connected = false;
  refused_at = {};
  if (!stopping) link_stats.trouble = status.ok() ? "the slave ended the stream" : WordsOf(status);
  link_stats.answers = IsAnswer(status);
  link_stats.observes = ReasonOf(status) == v1::ERROR_REASON_NO_MANIPULATOR;
  if (link_stats.observes) link_stats.trouble.clear();
  denied = !was_connected && status.error_code() == grpc::StatusCode::PERMISSION_DENIED;
  return status;
}

void SlaveLink::Parts::Served() {
  const std::scoped_lock lock(mutex);
  if (was_connected) ++link_stats.reconnects;
  link_stats.connected = was_connected = true;
  link_stats.observes = false;
  denied = false;
  link_stats.trouble.clear();
  unread.clear();  // the settings were read before this stream began
  datagram_at = Clock::now();
}

bool SlaveLink::Parts::LacksDatagrams() const {
  const milliseconds timeout = std::max<milliseconds>(DatagramLine::kSilence, max_round_trip);
  const bool asked = options.datagrams.value_or(false);  // else there is nothing to report
  return asked && link_stats.connected && SinceThen(datagram_at) > timeout;
}

void SlaveLink::Parts::Refused(const std::string& reason) {
  const std::scoped_lock lock(mutex);
  ++link_stats.refused;
  refusal = "a state was rejected: " + reason;
  refused_at = Clock::now();
}

void SlaveLink::Parts::Observe(std::optional<milliseconds> duration, const std::stop_token& stop,
                               LatestValue<ReceivedState>* states) {
  v1::WatchStateRequest request;
  request.set_max_rate(kObservedRate);
  request.set_details(options.details);
  grpc::ClientContext context;
  if (duration) SetDeadline(&context, *duration);
  const OperatorCalls::Scope runs(&calls, &context);
  const auto stream = stub->WatchState(&context, request);
  auto message = std::make_shared<v1::SlaveState>();
  while (!stop.stop_requested() && stream->Read(message.get())) {
    std::string reason;
    const auto state = FromProto(*message, &reason);
    if (!state) continue;
    const Time now = Clock::now();
    Keep(*state, {std::exchange(message, std::make_shared<v1::SlaveState>()), now});
    // A state that has waited on the link is old, although it has just arrived.
    const double offset = observed_clock.Add(*state, now);
    states->Put({.state = *state,
                 .received_at = state->sent_at - Seconds(offset),
                 .clock_offset = offset,
                 .observed = true});
    if (state->settings_revision != read_revision) break;
  }
  context.TryCancel();
  static_cast<void>(stream->Finish());
}

void SlaveLink::Parts::WatchAlone(const std::stop_token& stop, LatestValue<ReceivedState>* states) {
  const auto show = [this](bool observes) {
    const std::scoped_lock lock(mutex);
    link_stats.observes = observes;
    link_stats.trouble = observes ? "" : "the slave ended the stream";
  };
  show(true);
  Observe(std::nullopt, stop, states);
  show(false);
}

bool SlaveLink::Parts::SleepUntil(std::chrono::steady_clock::time_point due) {
  std::unique_lock lock(mutex);
  return !changed.wait_until(lock, due, [this] { return stopping; });
}

bool SlaveLink::Parts::WaitForConnection(milliseconds duration) {
  if (channel->GetState(true) == GRPC_CHANNEL_READY) return Sleep(duration);
  channel->WaitForConnected(std::chrono::system_clock::now() + duration);
  return Sleep(milliseconds(0));
}

SlaveLink::SlaveLink(Options options) : parts_(std::make_unique<Parts>(std::move(options))) {}

SlaveLink::~SlaveLink() {
  Stop();
}

RemoteScene SlaveLink::Connect() {
  const Time start = Clock::now();
  Backoff backoff(kFirstRetry, kMaxRetry);
  const milliseconds wait(static_cast<std::int64_t>(1000 * parts_->options.wait));
  milliseconds timeout = OperatorCalls::kMinDeadline;  // a long line needs more than one round trip
  RemoteScene scene;
  grpc::Status status;
  for (int attempts = 1;; ++attempts) {
    const Time asked = Clock::now();
    const milliseconds left = std::max(OperatorCalls::kMinDeadline, wait - SinceThen(start));
    status = parts_->RequestScene(&scene, false, std::min(timeout, left));
    if (status.ok()) {
      parts_->Open(std::max(parts_->options.max_round_trip, kTripsBorne * parts_->answered_in));
      parts_->first = scene;
      return scene;
    }
    if (SinceThen(asked) >= kNoRefusal) timeout = std::min(2 * timeout, kMaxDeadline);
    if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED) {
      throw std::runtime_error(
          parts_->target +
          " answers, but does not speak palpate.v1: is it a palpate-slave of a "
          "compatible release?");
    }
    if (status.error_code() == grpc::StatusCode::PERMISSION_DENIED) {
      throw std::runtime_error(parts_->target + " rejects this: " + WordsOf(status));
    }
    const double passed = SecondsBetween(start, Clock::now());
    const bool more = passed < parts_->options.wait;
    if (more && parts_->WaitForConnection(backoff.Next())) continue;
    throw std::runtime_error(
        Formatted("no slave at %s: %d attempts in %g s, the last: %s; is palpate-slave serving "
                  "there, and do both ends use --tls, or neither?",
                  parts_->target.c_str(), attempts, passed, WordsOf(status).c_str()));
  }
}

milliseconds SlaveLink::max_round_trip() const {
  return parts_->max_round_trip;
}

void SlaveLink::Start(LatestValue<ReceivedState>* states, LatestValue<OperatorCommand>* commands,
                      LatestValue<RemoteSettings>* settings, bool operates) {
  parts_->settings = settings;
  parts_->operates = operates;
  parts_->thread =
      std::jthread([parts = parts_.get(), states, commands](const std::stop_token& stop) {
        parts->Run(stop, states, commands);
      });
}

void SlaveLink::EndCalls() {
  parts_->calls.End();
}

void SlaveLink::Stop() {
  EndCalls();
  parts_->thread.request_stop();
  {
    std::unique_lock lock(parts_->mutex);
    parts_->stopping = true;
    parts_->changed.notify_all();
    const auto ended = [this] { return parts_->session == nullptr; };
    const auto due = std::chrono::steady_clock::now() + kGrace;
    if (!parts_->changed.wait_until(lock, due, ended)) parts_->session->Cancel();
  }
  if (parts_->thread.joinable()) parts_->thread.join();
}

LinkStats SlaveLink::stats() const {
  const RoundTrips::Times times = parts_->trips.times();
  std::unique_lock lock(parts_->mutex);
  LinkStats stats = parts_->link_stats;
  if (SinceThen(parts_->refused_at) < kReportedAfterwards) stats.trouble = parts_->refusal;
  if (stats.trouble.empty()) stats.trouble = parts_->unread;
  if (stats.trouble.empty() && parts_->LacksDatagrams()) stats.trouble = kNoDatagrams;
  lock.unlock();
  stats.states = parts_->states_received;
  stats.commands = parts_->commands_sent;
  stats.rtt_p50_us = times.rtt.Quantile(0.5);
  stats.rtt_p99_us = times.rtt.Quantile(0.99);
  stats.rtt_max_us = times.rtt.max();
  stats.states_by_datagram = parts_->states_by_datagram;
  stats.delay = TimesOf(times.delay);
  stats.age = TimesOf(times.age);
  stats.command_age = TimesOf(times.command_age);
  stats.clock_offset = parts_->trips.clock_offset();
  return stats;
}

StateRecord SlaveLink::state() const {
  const std::scoped_lock lock(parts_->states_mutex);
  return parts_->newest;
}

Events SlaveLink::TakeEvents() {
  const std::scoped_lock lock(parts_->states_mutex);
  return std::exchange(parts_->events, Events());
}

bool SlaveLink::denied() const {
  return parts_->denied;
}

OperatorCalls& SlaveLink::calls() {
  return parts_->calls;
}

}  // namespace palpate
