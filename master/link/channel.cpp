#include "master/link/channel.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include "shared/link/loopback.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"

namespace palpate {
namespace {

constexpr int kFirstRetryMs = 50, kMaxRetryMs = 500;
// gRPC gives up an attempt after this number of round trips: a handshake takes several of them, or
// longer on a busy machine.
constexpr int kHandshakeTrips = 3;
constexpr int kKeepaliveMs = 1000;
// Largest amount of data in transit [bytes]. Ticks: twice 200 states of 256 bytes per second of
// round trip; the loop's limit on age bounds the number of old states after a stall.
constexpr int kTickWindow = 2 * 200 * 256, kBulkWindow = 65536;
constexpr std::chrono::milliseconds kSecond(1000), kMaxWait(30000);
constexpr int kMaxMesh = 64 << 20;  // [bytes]

class OperatorName final : public grpc::ClientContext::GlobalCallbacks {
 public:
  explicit OperatorName(std::string name) : name_(std::move(name)) {}
  void DefaultConstructor(grpc::ClientContext* context) override {
    context->AddMetadata("palpate-operator-bin", name_);
  }
  void Destructor(grpc::ClientContext* /*context*/) override {}

 private:
  const std::string name_;
};

constexpr std::size_t kMaxReasonLength = 300;  // [characters]

// A part of a gRPC message, and the words shown for it. The first match counts.
struct Row {
  std::string_view part, words;
};
constexpr std::array<Row, 12> kRows{{
    {"Deadline Exceeded", "no answer in time"},
    {"Connection refused", "no program listens there"},
    {"DNS resolution failed", "unknown host name"},
    {"Network is unreachable", "no route to that machine"},
    {"No route to host", "no route to that machine"},
    {"timed out", "that machine does not answer"},
    {"Timeout occurred", "that machine does not answer"},
    {"eepalive", "the slave has not answered in time: it is busy, or the link is cut"},
    {"Socket closed", "the connection was closed"},
    {"Connection reset", "the connection was closed"},
    {"Broken pipe", "the connection was closed"},
    {"Endpoint read failed", "the connection was closed"},
}};

// Codes of the transport. The slave itself returns UNAVAILABLE only when it stops.
bool IsOfTheLine(grpc::StatusCode code) {
  return code == grpc::StatusCode::UNAVAILABLE || code == grpc::StatusCode::DEADLINE_EXCEEDED;
}

}  // namespace

void NameCalls(const std::string& name) {
  static OperatorName callbacks(name);
  grpc::ClientContext::SetGlobalCallbacks(&callbacks);
}

std::shared_ptr<grpc::Channel> OpenChannel(const std::string& target, Traffic traffic,
                                           const std::filesystem::path& tls,
                                           std::chrono::milliseconds max_round_trip) {
  const int trip_ms = static_cast<int>(std::clamp(max_round_trip, kSecond, kMaxWait).count());
  const bool bulk = traffic == Traffic::kBulk;
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kFirstRetryMs);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, kHandshakeTrips * trip_ms);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kMaxRetryMs);
  // The window of the whole connection is 64 kB. Only the bandwidth probe enlarges it, which a link
  // with a long delay needs; on a short one it would only buffer old data.
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, trip_ms > kSecond.count());
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES,
                   bulk ? kBulkWindow : kTickWindow * (trip_ms / 1000));
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, trip_ms);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);  // a proxy would only add delay
  if (bulk) arguments.SetMaxReceiveMessageSize(kMaxMesh);
  const auto credentials = tls.empty() ? grpc::InsecureChannelCredentials() : ChannelTls(tls);
  return grpc::CreateCustomChannel(target, credentials, arguments);
}

std::string PermittedTarget(const std::string& target, bool beyond) {
  const Endpoint endpoint = ParseEndpoint(target);
  RequireLoopbackUnless(beyond, endpoint);
  return ToString(endpoint);
}

std::string WordsOf(const grpc::Status& status) {
  const std::string& message = status.error_message();
  if (IsOfTheLine(status.error_code())) {
    const auto row = std::ranges::find_if(
        kRows, [&](const Row& one) { return message.find(one.part) != std::string::npos; });
    if (row != kRows.end()) return std::string(row->words);
  }
  return Presentable(message, kMaxReasonLength);
}

}  // namespace palpate
