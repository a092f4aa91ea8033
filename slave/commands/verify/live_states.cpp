#include "slave/commands/verify/live_states.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "shared/link/loopback.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

// The measured force is as of the sending of a state. Between those around `at`; the states end
// with the one whose sample is of that time.
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

void LiveStates::Watch(double seconds, const std::stop_token& stop) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::duration_cast<std::chrono::milliseconds>(
                           std::chrono::duration<double>(seconds)));
  const std::stop_callback cancel(stop, [&] { context.TryCancel(); });
  const auto stream = connection_->stub->WatchState(&context, {});
  constexpr std::size_t kMost = 200;  // states that a sample may be older than its state
  std::vector<SlaveState> last;
  std::string why;
  for (v1::SlaveState message; stream->Read(&message);) {
    const std::optional<SlaveState> state = FromProto(message, &why);
    if (!state) continue;
    const bool is_new = last.empty() || state->sensed_at != last.back().sensed_at;
    if (last.size() == kMost) last.erase(last.begin(), last.begin() + kMost / 2);
    last.push_back(*state);
    if (states_.empty()) start_ = state->sensed_at;
    const double t = SecondsBetween(start_, state->sensed_at);
    if (is_new && (states_.empty() || t > now())) {
      const bool touches = state->force && state->force->norm() > 0;
      states_.push_back({.t = t,
                         .finger = {},
                         .p_S_tip = state->p_S_tip,
                         .force = IsForceKnown(*state) ? *state->force : kUnknownVector3,
                         .depth = touches && state->local_model.known()
                                      ? state->local_model.Penetration(state->p_S_tip)
                                      : kUnknown,
                         .sigma = state->sigma,
                         .is_valid = state->validity == Validity::kValid,
                         .validity = std::string(ToString(state->validity)),
                         .measured = MeasuredAt(state->sensed_at, last)});
    }
  }
  const grpc::Status status = stream->Finish();
  if (!last.empty() || stop.stop_requested()) return;
  throw NoState(address_ + ": no state from a slave: " +
                (why.empty() ? Presentable(status.error_message(), 300) : why));
}

}  // namespace palpate
