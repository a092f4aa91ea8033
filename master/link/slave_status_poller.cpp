#include "master/link/slave_status_poller.h"

#include <map>

#include <google/protobuf/util/json_util.h>

#include "master/link/stream_keeper.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kAskEvery(1000);
constexpr double kStateRate = 30;   // [Hz]
constexpr double kTraceRate = 120;  // [Hz]
constexpr double kTraceAge = 1;     // [s]
constexpr std::size_t kTracesKept = 2048;

v1::WatchStateRequest Request() {
  v1::WatchStateRequest request;
  request.set_max_rate_hz(kStateRate);
  request.set_details(true);
  return request;
}

v1::WatchTraceRequest TraceRequest() {
  v1::WatchTraceRequest request;
  request.set_max_rate_hz(kTraceRate);
  return request;
}

}  // namespace

std::string JsonOf(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto written = google::protobuf::util::MessageToJsonString(message, &json, options);
  return written.ok() ? json : std::string();
}

struct SlaveStatusPoller::Parts {
  explicit Parts(const SlaveLink::Options& link) : stub(BulkStub(link)) {}

  // Both ignore what is no state or trace.
  std::string Take(const v1::SlaveState& message);
  std::string Take(const v1::TraceUpdate& message);
  void Run(const std::stop_token& stop);
  // Messages of the slave, or why there are none.
  Words Poll(const std::stop_token& stop);

  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  mutable std::mutex mutex;  // guards what follows
  std::condition_variable_any asked;
  ObservedState felt;
  Events events;
  Words words;
  std::map<Time, SampleTrace> traces;  // by when their samples were taken
  StreamKeeper<v1::SlaveState> states{
      [this](grpc::ClientContext* context) { return stub->WatchState(context, Request()); },
      [this](v1::SlaveState* message) { return Take(*message); }};
  StreamKeeper<v1::TraceUpdate> told_traces{
      [this](grpc::ClientContext* context) { return stub->WatchTrace(context, TraceRequest()); },
      [this](v1::TraceUpdate* message) { return Take(*message); }};
  std::jthread asking{[this](const std::stop_token& stop) { Run(stop); }};  // last
};

std::string SlaveStatusPoller::Parts::Take(const v1::SlaveState& message) {
  std::string reason;
  const auto state = FromProto(message, &reason);
  if (!state) return {};  // already known from the Operate stream
  std::string details = JsonOf(message.details());
  const std::scoped_lock lock(mutex);
  felt = {*state, std::move(details), Clock::now()};
  events.Add(state->events);
  return {};
}

std::string SlaveStatusPoller::Parts::Take(const v1::TraceUpdate& message) {
  const std::scoped_lock lock(mutex);
  for (const v1::SampleTrace& told : message.samples()) {
    std::string reason;
    if (const auto trace = FromProto(told, &reason)) traces[trace->sensed_at] = *trace;
  }
  const auto is_old = [this] {
    return SecondsBetween(traces.begin()->first, traces.rbegin()->first) > kTraceAge;
  };
  while (!traces.empty() && (is_old() || traces.size() > kTracesKept)) {
    traces.erase(traces.begin());
  }
  return {};
}

void SlaveStatusPoller::Parts::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Words told = Poll(stop);
    std::unique_lock lock(mutex);
    told.version = words.version + 1;
    words = std::move(told);
    asked.wait_for(lock, stop, kAskEvery, [] { return false; });
  }
}

SlaveStatusPoller::Words SlaveStatusPoller::Parts::Poll(const std::stop_token& stop) {
  using Stub = v1::Teleoperation::Stub;
  Words told;
  // Adds the answer of one call unless one before failed.
  const auto add = [&](auto call, auto reply, std::string* json) {
    if (!told.trouble.empty()) return;
    const grpc::Status status = Query(stub.get(), call, stop, &reply);
    if (status.ok()) {
      *json = JsonOf(reply);
    } else {
      told.trouble = WordsOf(status);
    }
  };
  add(&Stub::GetStatus, v1::Status(), &told.status);
  add(&Stub::GetScene, v1::SceneDescription(), &told.scene);
  add(&Stub::GetCapabilities, v1::Capabilities(), &told.capabilities);
  return told;
}

SlaveStatusPoller::SlaveStatusPoller(const SlaveLink::Options& link)
    : parts_(std::make_unique<Parts>(link)) {}

SlaveStatusPoller::~SlaveStatusPoller() = default;

SlaveStatusPoller::ObservedState SlaveStatusPoller::felt() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->felt;
}

std::optional<SampleTrace> SlaveStatusPoller::TraceOf(Time sensed_at) const {
  const std::scoped_lock lock(parts_->mutex);
  const auto found = parts_->traces.find(sensed_at);
  return found == parts_->traces.end() ? std::nullopt : std::optional(found->second);
}

Events SlaveStatusPoller::TakeEvents() {
  const std::scoped_lock lock(parts_->mutex);
  return std::exchange(parts_->events, Events());
}

SlaveStatusPoller::Words SlaveStatusPoller::words() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->words;
}

}  // namespace palpate
