#include "slave/commands/verify/live_states.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "shared/link/loopback.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

// Returns the measured force at `at`. It is measured when a state is sent, so it is interpolated
// between the states around `at`; the last state is the one with the sample of that time.
Eigen::Vector3d MeasuredAt(Time at, const std::vector<SlaveState>& states) {
  const auto after = std::ranges::find_if(states, [&](const auto& s) { return s.sent_at >= at; });
  if (after == states.end() || !after->true_force) return kUnknownVector3;
  if (after == states.begin() || !std::prev(after)->true_force) return *after->true_force;
  const auto before = std::prev(after);
  const double share =
      SecondsBetween(before->sent_at, at) / SecondsBetween(before->sent_at, after->sent_at);
  return *before->true_force + share * (*after->true_force - *before->true_force);
}

}  // namespace

struct LiveStates::Connection {
  std::unique_ptr<v1::Teleoperation::Stub> stub;
};

LiveStates::LiveStates(const std::string& address, const std::filesystem::path& tls, bool insecure)
    : connection_(std::make_unique<Connection>()) {
  const Endpoint endpoint = ParseEndpoint(address);
  if (tls.empty()) RequireLoopbackUnless(insecure, endpoint);
  address_ = ToString(endpoint);
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  connection_->stub = v1::Teleoperation::NewStub(grpc::CreateCustomChannel(
      address_, tls.empty() ? grpc::InsecureChannelCredentials() : ChannelTls(tls), arguments));
}

LiveStates::~LiveStates() = default;

std::vector<ForceRow> LiveStates::Watch(double seconds, const std::stop_token& stop) {
  using std::chrono::duration;
  using std::chrono::system_clock;
  constexpr double kTimeout = 5, kRetry = 0.2;  // [s]
  constexpr std::size_t kMaxStates = 200;       // largest age of a sample, in states
  const auto begin = system_clock::now();
  const auto elapsed = [begin] { return duration<double>(system_clock::now() - begin).count(); };
  std::vector<ForceRow> rows;
  bool is_complete = false;
  std::string why;
  do {
    grpc::ClientContext context;
    context.set_deadline(begin + std::chrono::duration_cast<system_clock::duration>(
                                     duration<double>(seconds + kTimeout)));
    const std::stop_callback cancel(stop, [&] { context.TryCancel(); });
    const auto stream = connection_->stub->WatchState(&context, {});
    std::vector<SlaveState> last;
    for (v1::SlaveState message; !is_complete && stream->Read(&message);) {
      const std::optional<SlaveState> state = FromProto(message, &why);
      if (!state) continue;
      if (last.size() == kMaxStates) last.erase(last.begin(), last.begin() + kMaxStates / 2);
      last.push_back(*state);
      const bool is_first = !start_;
      if (is_first) start_ = state->sensed_at;
      const double t = SecondsBetween(*start_, state->sensed_at);
      if (!is_first && t <= last_) continue;
      last_ = t;
      ForceRow row;
      row.t = t;
      row.measured = MeasuredAt(state->sensed_at, last);
      if (IsForceKnown(*state)) row.estimated = *state->force;
      row.sigma = state->sigma;
      row.is_valid = state->validity == Validity::kValid;
      row.p_estimated = state->p_S_tip;
      const bool touches = state->force && state->force->norm() > 0;
      if (touches && state->local_model.known()) {
        row.depth = state->local_model.Penetration(state->p_S_tip);
      }
      rows.push_back(row);
      is_complete = t - rows.front().t >= seconds;
    }
    if (is_complete) context.TryCancel();
    const grpc::Status status = stream->Finish();
    if (why.empty()) why = Presentable(status.error_message(), 300);
    if (!is_complete) std::this_thread::sleep_for(duration<double>(kRetry));
  } while (!is_complete && !stop.stop_requested() && elapsed() < seconds + kTimeout);
  if (rows.empty() && !stop.stop_requested()) {
    throw std::runtime_error(address_ + ": no state from a slave: " + why);
  }
  return rows;
}

}  // namespace palpate
