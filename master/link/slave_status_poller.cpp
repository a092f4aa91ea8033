#include "master/link/slave_status_poller.h"

#include <map>

#include <google/protobuf/util/json_util.h>

#include "master/link/stream_keeper.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kAskEvery(1000), kPatience(1000);
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
  Words Poll();
  // Adds the answer of one call to `json` unless one before failed.
  template <class Request, class Reply, class Call>
  void Add(Call call, std::string* json, std::string* trouble);

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
    Words told = Poll();
    std::unique_lock lock(mutex);
    told.version = words.version + 1;
    words = std::move(told);
    asked.wait_for(lock, stop, kAskEvery, [] { return false; });
  }
}

template <class Request, class Reply, class Call>
void SlaveStatusPoller::Parts::Add(Call call, std::string* json, std::string* trouble) {
  if (!trouble->empty()) return;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  Reply reply;
  const grpc::Status status = (stub.get()->*call)(&context, Request(), &reply);
  if (status.ok()) {
    *json = JsonOf(reply);
  } else {
    *trouble = WordsOf(status);
  }
}

SlaveStatusPoller::Words SlaveStatusPoller::Parts::Poll() {
  using Stub = v1::Teleoperation::Stub;
  Words told;
  Add<v1::GetStatusRequest, v1::Status>(&Stub::GetStatus, &told.status, &told.trouble);
  Add<v1::GetSceneRequest, v1::SceneDescription>(&Stub::GetScene, &told.scene, &told.trouble);
  Add<v1::GetCapabilitiesRequest, v1::Capabilities>(&Stub::GetCapabilities, &told.capabilities,
                                                    &told.trouble);
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
