#include "master/doctor/link_check.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"
#include "shared/link/clock_offset.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr int kCalls = 100;
constexpr double kMicro = 1e6, kMilli = 1e3;
constexpr std::chrono::seconds kMaxCall(20);
constexpr std::size_t kMaxWordsLength = 200;

using Stub = v1::Teleoperation::Stub;

Time FromStamp(const google::protobuf::Timestamp& stamp) {
  return Time{std::chrono::seconds(std::clamp<std::int64_t>(stamp.seconds(), 0, 1LL << 33)) +
              std::chrono::nanoseconds(std::clamp(stamp.nanos(), 0, 999999999))};
}

void Require(const grpc::Status& status) {
  if (!status.ok()) throw std::runtime_error(Presentable(status.error_message(), 300));
}

// Cancels a call when `stop` is requested.
auto Until(const std::stop_token& stop, grpc::ClientContext* context) {
  return std::stop_callback(stop, [context] { context->TryCancel(); });
}

const char* InWords(v1::Phase phase) {
  switch (phase) {
    case v1::PHASE_READY:
      return "ready: no operator is engaged";
    case v1::PHASE_FOLLOWING:
      return "the tool follows the operator";
    case v1::PHASE_CLUTCHED:
      return "the operator is disengaged: the tool is stopped";
    case v1::PHASE_HOLD:
      return "commands have stopped: the tool holds its position";
    case v1::PHASE_ESTOP:
      return "emergency stop";
    case v1::PHASE_OBSERVING:
      return "observing: the scene has no manipulator";
    case v1::PHASE_SETUP:
      return "set-up: the slave has no scene yet";
    default:
      return "unknown state";
  }
}

v1::Status QueryStatus(Stub& stub, const std::stop_token& stop, ClockOffset* offset,
                       LatencyHistogram* round_trip_us) {
  grpc::ClientContext context;
  const auto ends = Until(stop, &context);
  context.set_deadline(std::chrono::system_clock::now() + kMaxCall);
  v1::Status reply;
  const Time left = Clock::now();
  Require(stub.GetStatus(&context, {}, &reply));
  const Time came = Clock::now(), there = FromStamp(reply.now());
  round_trip_us->Add(kMicro * SecondsBetween(left, came));
  offset->Add(left, there, there, came);
  return reply;
}

void QueryLine(Stub& stub, double seconds, const std::stop_token& stop, LinkSample* line) {
  ClockOffset offset;
  const Time begin = Clock::now();
  v1::Status status;
  for (int i = 0; i < kCalls && SecondsBetween(begin, Clock::now()) < seconds; ++i) {
    status = QueryStatus(stub, stop, &offset, &line->round_trip_us);
  }
  line->clock_offset = offset.seconds();
  line->phase = InWords(status.phase());
  for (const std::string& alarm : status.alarms()) {
    line->alarms.push_back(Presentable(alarm, kMaxWordsLength));
  }
}

void Watch(Stub& stub, double dead_after, double seconds, const std::stop_token& stop,
           LinkSample* line) {
  grpc::ClientContext context;
  const auto ends = Until(stop, &context);
  const auto stream = stub.WatchState(&context, {});
  const Time begin = Clock::now();
  Time last{};
  v1::SlaveState message;
  std::string reason;
  while (SecondsBetween(begin, Clock::now()) < seconds && stream->Read(&message)) {
    const Time now = Clock::now();
    const auto state = FromProto(message, &reason);
    if (!state) throw std::runtime_error("a received state is invalid: " + reason);
    if (line->states++ > 0) {
      const double gap = SecondsBetween(last, now);
      line->gap_us.Add(kMicro * gap);
      line->seconds += gap;
      if (gap > dead_after) ++line->gaps_beyond;
    }
    last = now;
    if (state->sensed_at > Time{}) {
      line->age = SecondsBetween(state->sensed_at, now) + line->clock_offset;
    }
  }
  context.TryCancel();
  const grpc::Status status = stream->Finish();
  if (line->states == 0) Require(status);
}

Finding RoundTrip(const LinkSample& line) {
  const double p50 = line.round_trip_us.Quantile(0.5) / kMilli;
  Finding finding{
      Grade::kGood, "round trip",
      Formatted("median %.2f ms, 99 %% below %.2f ms, maximum %.2f ms", p50,
                line.round_trip_us.Quantile(0.99) / kMilli, line.round_trip_us.max() / kMilli),
      ""};
  constexpr double kImperceptible = 20, kSlow = 200;  // [ms]
  if (p50 <= kImperceptible) return finding;
  finding.grade = Grade::kNote;
  finding.advice =
      "use --render local (the default): it evaluates the contact model on this side, so that "
      "the delay does not affect stationary objects";
  if (p50 > kSlow) finding.advice += "; motion of the object is rendered this much later";
  return finding;
}

Finding Gaps(const LinkSample& line, double dead_after) {
  const double rate = line.seconds > 0 ? static_cast<double>(line.states - 1) / line.seconds : 0;
  Finding finding{
      Grade::kGood, "states",
      Formatted("%.0f per second, largest gap %.1f ms; the link times out after %.0f ms", rate,
                line.gap_us.max() / kMilli, kMilli * dead_after),
      ""};
  if (line.gaps_beyond > 0) {
    finding.grade = Grade::kBad;
    finding.advice = Formatted(
        "%llu gaps would have ended the engagement: use a better link, or set "
        "`link: {dead_after: %.0f ms}` in the slave's scene (at most 500 ms)",
        static_cast<unsigned long long>(line.gaps_beyond),
        std::min(kMilli * kMaxDeadAfter, 1.5 * line.gap_us.max() / kMilli));
  }
  return finding;
}

Finding Clocks(const LinkSample& line) {
  constexpr double kMaxClockDifference = 60;  // [s]
  Finding finding{Grade::kGood, "clocks",
                  Formatted("the slave's clock differs by %+.3f s", line.clock_offset), ""};
  if (line.age) {
    finding.measured += Formatted("; a sample is %.1f ms old when it arrives", kMilli * *line.age);
  }
  if (std::abs(line.clock_offset) > kMaxClockDifference) {
    finding.grade = Grade::kNote;
    finding.advice = "this affects only times in logs and certificates: run NTP at both ends";
  }
  return finding;
}

Finding Samples(const LinkSample& line) {
  if (line.age) return {Grade::kGood, "sensing", "samples arrive", ""};
  return {Grade::kNote, "sensing", "nothing was sensed yet",
          "start the driver of the camera or the fingertips, or palpate-simulator for a simulated "
          "scene"};
}

Finding Versions(const LinkSample& line) {
  if (line.version == Version()) return {Grade::kGood, "version", line.version, ""};
  return {Grade::kNote, "version", "the slave is " + line.version + ", this master " + Version(),
          "they work together, but features that only one of them has are off"};
}

Finding Health(const LinkSample& line) {
  Finding finding{Grade::kGood, "slave", line.phase, ""};
  if (line.alarms.empty()) return finding;
  finding.grade = Grade::kNote;
  for (const std::string& alarm : line.alarms) finding.measured += "; " + alarm;
  finding.advice = "see the slave's log";
  return finding;
}

}  // namespace

LinkSample MeasureLink(const SlaveLink::Options& options, const RemoteScene& scene, double seconds,
                       const std::stop_token& stop) {
  const bool beyond = options.insecure || !options.tls.empty();
  const auto stub =
      v1::Teleoperation::NewStub(OpenChannel(PermittedTarget(options.target, beyond),
                                             Traffic::kTicks, options.tls, options.max_round_trip));
  LinkSample line;
  line.version = scene.version;
  QueryLine(*stub, seconds, stop, &line);
  Watch(*stub, scene.dead_after, seconds, stop, &line);
  return line;
}

Findings CheckLink(const LinkSample& line, const RemoteScene& scene) {
  return {Versions(line), RoundTrip(line), Gaps(line, scene.dead_after),
          Clocks(line),   Samples(line),   Health(line)};
}

LinkStats TryDatagrams(SlaveLink::Options options, double seconds) {
  constexpr std::chrono::milliseconds kLook(5);
  constexpr double kTripsToBegin = 3;
  options.datagrams = true;
  const double timeout =
      seconds + kTripsToBegin * static_cast<double>(options.max_round_trip.count()) / kMilli;
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  SlaveLink link(std::move(options));
  link.Start(&states, &commands, &settings, true);
  const Time begin = Clock::now();
  LinkStats stats;
  OperatorCommand disengaged;
  while (stats.states_by_datagram == 0 && SecondsBetween(begin, Clock::now()) < timeout) {
    ++disengaged.sequence;
    commands.Put(disengaged);
    std::this_thread::sleep_for(kLook);
    stats = link.stats();
  }
  link.Stop();
  return stats;
}

Finding CheckDatagrams(const LinkStats& tried) {
  if (tried.states_by_datagram > 0) {
    return {Grade::kGood, "datagrams", "received", ""};
  }
  if (!tried.connected) {
    return {Grade::kNote, "datagrams", "not tried: " + tried.trouble,
            "this test needs the lease and the role operator: repeat it while nobody operates"};
  }
  return {Grade::kNote, "datagrams", "none received",
          "open UDP to the slave's port; without it states and commands use TCP alone, where a "
          "lost packet delays the next ones"};
}

Findings ExamineLink(const SlaveLink::Options& options, double seconds,
                     const std::stop_token& stop) {
  try {
    SlaveLink link(options);
    const RemoteScene scene = link.Connect();
    SlaveLink::Options measured = options;
    measured.max_round_trip = link.max_round_trip();
    Findings findings{{Grade::kGood, "scene", scene.name + ", " + scene.model, ""}};
    for (Finding& finding : CheckLink(MeasureLink(measured, scene, seconds, stop), scene)) {
      findings.push_back(std::move(finding));
    }
    if (measured.datagrams.value_or(false))
      findings.push_back(CheckDatagrams(TryDatagrams(measured, seconds)));
    return findings;
  } catch (const std::exception& error) {
    return {{Grade::kBad, "link", error.what(),
             "check that `palpate-slave serve` runs and listens on that address; between machines "
             "both ends need --tls DIR or --insecure"}};
  }
}

}  // namespace palpate
