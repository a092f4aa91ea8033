#include "slave/service/server.h"

#include <chrono>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>

#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <spdlog/spdlog.h>

#include "shared/link/loopback.h"
#include "shared/link/thread_priority.h"
#include "shared/tls/credentials.h"
#include "slave/service/admission/acceptor.h"
#include "slave/service/listener_watch.h"
#include "slave/service/publisher.h"
#include "slave/service/roles.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr int kMaxRequestBytes = 64 * 1024;
constexpr int kMaxPictureBytes = 32 * 1024 * 1024;  // a raw pair of 2448 x 2048 px in colour
constexpr double kPictureShare =
    256;  // of a connection's budget where drivers push pictures: 64 MB/s
constexpr int kMaxStreamsPerConnection = 2 * ObserverSeats::kSeats;
constexpr int kMaxThreads = 2 * ObserverSeats::kSeats;
// Of a handshake, over 5 s of round trip.
constexpr int kHandshakeMs = 15000;
// [bytes] of commands on their way at most: 500 a second of 128 bytes for 5 s of round trip, with
// what each is wrapped in.
constexpr int kCommandWindow = 512 * 1024;
constexpr std::chrono::milliseconds kHealthPeriod(50);
constexpr std::chrono::milliseconds kGrace(300);  // for streams to end by themselves

Endpoint Permitted(const std::string& address, bool insecure) {
  try {
    const Endpoint endpoint = ParseEndpoint(address);
    RequireLoopbackUnless(insecure, endpoint);
    return endpoint;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
  }
}

// gRPC logs each handshake that fails, as that of the watch does.
ListenerWatch::Options WatchOf(Greeting greeting) {
  ListenerWatch::Options options{.greeting = greeting};
  if (greeting == Greeting::kTls) options.period = std::chrono::seconds(60);
  return options;
}

// Who is deaf: the door's own thread, or what it hands on to.
void LogMissedProbes(int missed, const AcceptorCounts& door) {
  spdlog::warn(
      "the listener does not respond to probes ({} in a row): last poll {:.1f} s ago, {} "
      "connections wait, {} are open",
      missed, door.unseen, door.waiting, door.open);
}

// To gRPC, which owns the connection from then on.
Acceptor::HandOn HandOnTo(grpc::experimental::ExternalConnectionAcceptor* grpc) {
  return [grpc](int fd) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
    connection.fd = fd;
    grpc->HandleNewConnection(&connection);
  };
}

std::shared_ptr<grpc::ServerCredentials> CredentialsFrom(
    const std::filesystem::path& tls, const std::shared_ptr<RevocationList>& revoked) {
  if (tls.empty()) return grpc::InsecureServerCredentials();
  auto credentials = ServerTls(tls, revoked);
  credentials->SetAuthMetadataProcessor(RoleCheck(revoked));
  // Another may be issued, and the clock set, while it serves.
  const std::string untimely = WhyUntimely(tls);
  if (!untimely.empty()) spdlog::error("audit: no client can connect: {}", untimely);
  return credentials;
}

void Configure(bool takes_pictures, grpc::ServerBuilder* builder) {
  builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  // The window of a whole connection is 64 kB, which holds no 5 s of commands; the probe lets it
  // grow on lines that are long.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 1);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kCommandWindow);
  builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreamsPerConnection);
  // No keepalive of ours: gRPC 1.51 aborts where its timer meets a connection that closes. Lease
  // and watchdog notice a line that was cut.
  // Who pings too often is not told so: gRPC would keep an error for each ping until it has closed
  // the connection, 100 MB in a moment. The door counts their bytes.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, 0);
  builder->SetMaxReceiveMessageSize(takes_pictures ? kMaxPictureBytes : kMaxRequestBytes);
  builder->SetResourceQuota(grpc::ResourceQuota("palpate").SetMaxThreads(kMaxThreads));
}

// Its own way to say something may wait for whoever reads the log, with a connection in its hands.
void LogGrpc(gpr_log_func_args* said) {
  spdlog::warn("gRPC: {}", said->message);
}

}  // namespace

// A deaf listener in a living process is worse than none: whoever supervises starts it anew.
void EndProcess() {
  spdlog::critical("no client can connect any more: the process ends, to be restarted");
  std::_Exit(EXIT_FAILURE);
}

struct Server::Parts {
  Parts(Slave& served, Endpoint listen_on, const std::filesystem::path& tls)
      : slave(served),
        endpoint(std::move(listen_on)),
        revoked(tls.empty() ? nullptr : std::make_shared<RevocationList>(tls)),
        publisher(slave),
        service(
            slave, publisher,
            {[this](const grpc::ServerContextBase& context) { KeepWhileTrusted(context); },
             [this](const std::string& peer) { door->Pace(peer); },
             [this](const std::string& peer, double trip) { door->HearRoundTrip(peer, trip); }}) {}

  void Build(const std::filesystem::path& tls);
  // A stream outlives no certificate: its connection is cut, and the tool stands.
  void KeepWhileTrusted(const grpc::ServerContextBase& context);

  // Health follows what is sensed.
  void UpdateHealth() const;
  void KeepHealthUpdated(const std::stop_token& stop) const;

  Slave& slave;
  Endpoint endpoint;
  const std::shared_ptr<RevocationList> revoked;  // null: plain text
  std::string address;
  Publisher publisher;
  TeleoperationService service;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections;
  std::unique_ptr<grpc::Server> server;
  std::optional<Acceptor> door;
  std::once_flag stopped;
  std::optional<ListenerWatch> listener;
  std::jthread telling;
};

void Server::Parts::KeepWhileTrusted(const grpc::ServerContextBase& context) {
  if (!revoked) return;
  const auto certificate = FactsOf(*context.auth_context());
  door->KeepWhile(context.peer(), [certificate, revoked = revoked] {
    return certificate && Holds(*certificate, *revoked);
  });
}

void Server::Parts::Build(const std::filesystem::path& tls) {
  const auto credentials = CredentialsFrom(tls, revoked);
  gpr_set_log_function(LogGrpc);
  grpc::EnableDefaultHealthCheckService(true);
  // Each of its streams holds a thread: for those on this machine.
  if (IsLoopback(endpoint.host)) grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  Configure(slave.picture_inbox() != nullptr, &builder);
  connections = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, credentials);
  builder.RegisterService(&service);
  server = builder.BuildAndStart();
}

void Server::Parts::UpdateHealth() const {
  const bool fresh = slave.Status().validity != Validity::kStale;
  server->GetHealthCheckService()->SetServingStatus(v1::Teleoperation::service_full_name(), fresh);
}

void Server::Parts::KeepHealthUpdated(const std::stop_token& stop) const {
  for (; !stop.stop_requested(); std::this_thread::sleep_for(kHealthPeriod)) UpdateHealth();
}

Server::Server(Slave& slave, const std::string& address, bool insecure,
               const std::filesystem::path& tls, std::function<void()> on_deaf)
    : parts_(std::make_unique<Parts>(slave, Permitted(address, insecure || !tls.empty()), tls)) {
  // Whatever of gRPC's threads the operator's words pass must not wait behind ordinary ones, as its
  // executor did: it also serves strangers.
  MakeWithRealtimeThreads(kReadingPriority, [&] { parts_->Build(tls); });
  if (!parts_->server) throw std::runtime_error("cannot serve on " + address);
  const Greeting greeting = tls.empty() ? Greeting::kHttp2 : Greeting::kTls;
  parts_->door.emplace(parts_->endpoint, greeting, HandOnTo(parts_->connections.get()),
                       Acceptor::Limits{.share = slave.picture_inbox() ? kPictureShare : 1});
  parts_->endpoint = parts_->door->endpoint();
  parts_->address = ToString(parts_->endpoint);
  parts_->door->Start();
  parts_->UpdateHealth();  // nobody finds a service that is unknown
  parts_->telling =
      std::jthread([this](const std::stop_token& stop) { parts_->KeepHealthUpdated(stop); });
  ListenerWatch::Options watch = WatchOf(greeting);
  watch.on_missed = [&door = *parts_->door](int missed) { LogMissedProbes(missed, door.counts()); };
  parts_->listener.emplace(parts_->endpoint, on_deaf ? std::move(on_deaf) : EndProcess, watch);
}

Server::~Server() {
  Stop();
}

const std::string& Server::address() const {
  return parts_->address;
}

AcceptorCounts Server::connections() const {
  return parts_->door->counts();
}

void Server::Stop() {
  std::call_once(parts_->stopped, [this] {
    parts_->listener.reset();
    parts_->door->Stop();
    parts_->telling = {};
    parts_->server->GetHealthCheckService()->Shutdown();
    parts_->publisher.Stop();
    parts_->service.EndStreams();
    parts_->server->Shutdown(std::chrono::system_clock::now() + kGrace);
    parts_->server->Wait();
  });
}

}  // namespace palpate
