#include "master/link/slave_link.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"
#include "master/link/operate_session.h"
#include "master/link/remote_scene.h"
#include "shared/link/thread_priority.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry(50), kLongestRetry(500);
constexpr milliseconds kLeaseRetry(1000);
constexpr milliseconds kCallDeadline(1000);
constexpr milliseconds kGrace(300);  // for the slave to end the stream after our goodbye

// Of a peer that may mean harm, fit for a terminal.
std::string Words(const grpc::Status& status) {
  return Presentable(status.error_message(), 300);
}

void SetDeadline(grpc::ClientContext* context) {
  context->set_deadline(std::chrono::system_clock::now() + kCallDeadline);
}

}  // namespace

struct SlaveLink::Parts {
  explicit Parts(Options chosen)
      : options(std::move(chosen)),
        target(PermittedTarget(options.target, options.insecure || !options.tls.empty())),
        stub(v1::Teleoperation::NewStub(OpenChannel(target, Traffic::kTicks, options.tls))) {}

  // `waits`: for a connection, within the deadline. Nobody moves a connection on while no call
  // waits.
  grpc::Status AskForScene(RemoteScene* scene, bool waits);
  void Run(const std::stop_token& stop, LatestValue<ReceivedState>* states,
           LatestValue<OperatorCommand>* commands);
  // Reads what the master goes by. One at a time.
  grpc::Status ReadSettings();
  // A state tells of `revision`: reads again, beside the stream, if another was read.
  void SeeRevision(std::uint32_t revision);
  grpc::Status RunSession(OperateSession* session, const std::stop_token& stop);
  // There is no stream, or no more, for the reason that `status` tells; returns it.
  grpc::Status Failed(const grpc::Status& status);
  void Served();
  void Refused(const std::string& reason);
  // Sleeps for `duration`; false: stopping.
  bool Sleep(milliseconds duration);

  const Options options;
  const std::string target;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  RoundTrips trips;
  std::atomic<std::uint64_t> states_received{0}, commands_sent{0};
  LatestValue<RemoteSettings>* settings = nullptr;
  std::atomic<std::uint32_t> read_revision{0};
  std::atomic<bool> rereads{false};

  mutable std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  OperateSession* session = nullptr;
  bool stopping = false, was_connected = false;
  LinkStats told;  // but for what is counted elsewhere

  std::jthread rereading;  // the stream's thread alone starts and joins it
  std::jthread thread;     // last: it uses all of the above
};

grpc::Status SlaveLink::Parts::AskForScene(RemoteScene* scene, bool waits) {
  v1::SceneDescription description;
  v1::Capabilities capabilities;
  grpc::ClientContext for_scene, for_capabilities;
  SetDeadline(&for_scene);
  SetDeadline(&for_capabilities);
  for_scene.set_wait_for_ready(waits);
  grpc::Status status = stub->GetScene(&for_scene, {}, &description);
  if (status.ok()) status = stub->GetCapabilities(&for_capabilities, {}, &capabilities);
  if (status.ok()) *scene = ToRemoteScene(description, capabilities);
  return status;
}

grpc::Status SlaveLink::Parts::ReadSettings() {
  try {
    RemoteScene scene;
    grpc::Status status = AskForScene(&scene, true);
    if (!status.ok()) return status;
    settings->Put({scene.settings_revision, scene.transform, scene.force_limit});
    read_revision = scene.settings_revision;
    return status;
  } catch (const std::exception& error) {  // numbers that cannot be
    return {grpc::StatusCode::INTERNAL, error.what()};
  }
}

void SlaveLink::Parts::SeeRevision(std::uint32_t revision) {
  if (revision == read_revision || rereads.exchange(true)) return;
  rereading = std::jthread([this] {
    const grpc::Status status = ReadSettings();
    if (!status.ok()) {
      Refused(status.error_message());
      Sleep(kFirstRetry);
    }
    rereads = false;
  });
}

void SlaveLink::Parts::Run(const std::stop_token& stop, LatestValue<ReceivedState>* states,
                           LatestValue<OperatorCommand>* commands) {
  MakeThreadRealtime(kLinkPriority);
  Backoff backoff(kFirstRetry, kLongestRetry);
  while (!stop.stop_requested()) {
    OperateSession next(
        {*stub, *states, *commands, trips, states_received, commands_sent, [this] { Served(); },
         [this](std::uint32_t revision) { SeeRevision(revision); },
         [this](const std::string& reason) { Refused(reason); }, options.on_received,
         options.on_sent},
        options.operator_name);
    const grpc::Status read = ReadSettings();
    const grpc::Status status = read.ok() ? RunSession(&next, stop) : Failed(read);
    if (rereading.joinable()) rereading.join();
    if (next.was_served()) backoff.Reset();
    const bool held = status.error_code() == grpc::StatusCode::FAILED_PRECONDITION;
    if (!Sleep(held ? kLeaseRetry : backoff.Next())) return;
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
  told.connected = false;
  if (!stopping) told.trouble = status.ok() ? "the slave ended the stream" : Words(status);
  return status;
}

void SlaveLink::Parts::Served() {
  const std::scoped_lock lock(mutex);
  if (was_connected) ++told.reconnects;
  told.connected = was_connected = true;
  told.trouble.clear();
}

void SlaveLink::Parts::Refused(const std::string& reason) {
  const std::scoped_lock lock(mutex);
  ++told.refused;
  told.trouble = "a state was refused: " + reason;
}

bool SlaveLink::Parts::Sleep(milliseconds duration) {
  std::unique_lock lock(mutex);
  return !changed.wait_for(lock, duration, [this] { return stopping; });
}

SlaveLink::SlaveLink(Options options) : parts_(std::make_unique<Parts>(std::move(options))) {}

SlaveLink::~SlaveLink() {
  Stop();
}

RemoteScene SlaveLink::Connect() {
  const Time start = Clock::now();
  Backoff backoff(kFirstRetry, kLongestRetry);
  RemoteScene scene;
  grpc::Status status;
  for (int attempts = 1;; ++attempts) {
    status = parts_->AskForScene(&scene, false);
    if (status.ok()) return scene;
    if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED) {
      throw std::runtime_error(parts_->target + " answers, but does not speak palpate.v1");
    }
    const double passed = SecondsBetween(start, Clock::now());
    const bool more = passed < parts_->options.wait;
    if (more && parts_->Sleep(backoff.Next())) continue;
    throw std::runtime_error(Formatted("no slave at %s: %d attempts in %g s, the last: %s",
                                       parts_->target.c_str(), attempts, passed,
                                       Words(status).c_str()));
  }
}

void SlaveLink::Start(LatestValue<ReceivedState>* states, LatestValue<OperatorCommand>* commands,
                      LatestValue<RemoteSettings>* settings) {
  parts_->settings = settings;
  parts_->thread =
      std::jthread([parts = parts_.get(), states, commands](const std::stop_token& stop) {
        parts->Run(stop, states, commands);
      });
}

void SlaveLink::Stop() {
  parts_->thread.request_stop();
  {
    std::unique_lock lock(parts_->mutex);
    parts_->stopping = true;
    parts_->changed.notify_all();
    const auto ended = [this] { return parts_->session == nullptr; };
    if (!parts_->changed.wait_for(lock, kGrace, ended)) parts_->session->Cancel();
  }
  if (parts_->thread.joinable()) parts_->thread.join();
}

LinkStats SlaveLink::stats() const {
  const LatencyHistogram rtt = parts_->trips.rtt();
  std::unique_lock lock(parts_->mutex);
  LinkStats stats = parts_->told;
  lock.unlock();
  stats.states = parts_->states_received;
  stats.commands = parts_->commands_sent;
  stats.rtt_p50_us = rtt.Quantile(0.5);
  stats.rtt_p99_us = rtt.Quantile(0.99);
  stats.rtt_max_us = rtt.max();
  stats.clock_offset = parts_->trips.clock_offset();
  return stats;
}

bool SlaveLink::EmergencyStop(const std::string& reason) {
  grpc::ClientContext context;
  SetDeadline(&context);
  v1::StopRequest request;
  request.set_reason(reason);
  v1::Status reply;
  return parts_->stub->Stop(&context, request, &reply).ok();
}

bool SlaveLink::Reset() {
  grpc::ClientContext context;
  SetDeadline(&context);
  v1::Status reply;
  return parts_->stub->Reset(&context, {}, &reply).ok();
}

}  // namespace palpate
