#include "slave/service/server.h"

#include <chrono>
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
#include "slave/service/nats_feed.h"
#include "slave/service/publisher.h"
#include "slave/service/roles.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr int kMaxRequestBytes = 64 * 1024;
constexpr int kMaxImageBytes = 32 * 1024 * 1024;  // a raw pair of 2448 x 2048 px in colour
constexpr int kMaxStreams = 2 * TeleoperationService::kSeats;  // of a connection; also threads
// Longest handshake, for round trips above 5 s.
constexpr int kHandshakeMs = 15000;
// Largest amount of commands in transit [bytes]: 500 per second of 128 bytes, including framing,
// for 5 s of round trip.
constexpr int kCommandWindow = 512 * 1024;
// Burst of a connection [bytes]: a driver of images can fill one stream's window before its rate is
// known, in addition to other streams.
constexpr double kBurst = 2.0 * kCommandWindow;
constexpr std::chrono::milliseconds kHealthPeriod(50);

Endpoint Permitted(const std::string& address, bool insecure) {
  try {
    const Endpoint endpoint = ParseEndpoint(address);
    RequireLoopbackUnless(insecure, endpoint);
    return endpoint;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
  }
}

// Passes the connection to gRPC, which then owns it.
Acceptor::HandOn HandOnTo(grpc::experimental::ExternalConnectionAcceptor* grpc) {
  return [grpc](int fd) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
    connection.fd = fd;
    grpc->HandleNewConnection(&connection);
  };
}

std::shared_ptr<grpc::ServerCredentials> CredentialsFrom(const std::filesystem::path& tls) {
  if (tls.empty()) return grpc::InsecureServerCredentials();
  auto credentials = ServerTls(tls);
  credentials->SetAuthMetadataProcessor(RoleCheck());
  // Checked repeatedly, because a new certificate may be issued, or the clock set, during
  // operation.
  const std::string untimely = WhyUntimely(tls);
  if (!untimely.empty()) spdlog::error("audit: no client can connect: {}", untimely);
  return credentials;
}

// A proposal arrives before its connection is identified, so the burst must allow it.
double BurstOf(Slave& slave) {
  return slave.setup() != nullptr ? kBurst + kMaxImageBytes : kBurst;
}

// Returns whether requests contain images.
bool TakesImages(Slave& slave) {
  return slave.image_inbox() != nullptr || slave.setup() != nullptr;
}

void Configure(bool takes_images, grpc::ServerBuilder* builder) {
  builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  // The window of a whole connection is 64 kB, too small for 5 s of commands; the bandwidth probe
  // enlarges it on links with a long delay.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 1);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, kCommandWindow);
  builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreams);
  // No keepalive by the server: gRPC 1.51 aborts if its timer fires while a connection closes.
  // Lease and watchdog detect a cut link. No ping strikes: gRPC stores an error for each ping until
  // it has closed the connection, quickly 100 MB. Admission control counts the bytes.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, 0);
  builder->SetMaxReceiveMessageSize(takes_images ? kMaxImageBytes : kMaxRequestBytes);
  builder->SetResourceQuota(grpc::ResourceQuota("palpate").SetMaxThreads(kMaxStreams));
}

// Replaces gRPC's log, which blocks if it is not read.
void LogGrpc(gpr_log_func_args* entry) {
  spdlog::warn("gRPC: {}", entry->message);
}

}  // namespace

struct Server::Parts {
  Parts(Slave& served, Endpoint listen_on, const std::filesystem::path& tls)
      : slave(served),
        endpoint(std::move(listen_on)),
        uses_tls(!tls.empty()),
        publisher(slave),
        service(slave, publisher, [this](const grpc::ServerContextBase& context, double rate) {
          DescribeClient(context, rate);
        }) {
    publisher.Start();
  }

  void Build(const std::filesystem::path& tls);
  // A stream began or ended, and its connection may send `rate` [bytes/s]. It is closed when its
  // certificate is no longer valid, so that the tool holds.
  void DescribeClient(const grpc::ServerContextBase& context, double rate);

  // Sets the health status from the sensing.
  void UpdateHealth() const;
  void KeepHealthUpdated(const std::stop_token& stop) const;

  Slave& slave;
  Endpoint endpoint;
  const bool uses_tls;
  std::string address;
  Publisher publisher;
  TeleoperationService service;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections;
  std::unique_ptr<grpc::Server> server;
  std::optional<Acceptor> acceptor;
  std::optional<NatsFeed> feed;
  std::once_flag stopped;
  std::jthread health;
};

void Server::Parts::DescribeClient(const grpc::ServerContextBase& context, double rate) {
  Acceptor::Client client{.rate = rate};
  if (uses_tls) {
    client.trusted = [expiry = ExpiryOf(*context.auth_context())] {
      return expiry && std::chrono::system_clock::now() < *expiry;
    };
  }
  acceptor->Describe(context.peer(), std::move(client));
}

void Server::Parts::Build(const std::filesystem::path& tls) {
  const auto credentials = CredentialsFrom(tls);
  gpr_set_log_function(LogGrpc);
  grpc::EnableDefaultHealthCheckService(true);
  // Reflection is for local clients only, because each of its streams occupies a thread.
  if (IsLoopback(endpoint.host)) grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  Configure(TakesImages(slave), &builder);
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
               const std::filesystem::path& tls)
    : parts_(std::make_unique<Parts>(slave, Permitted(address, insecure || !tls.empty()), tls)) {
  // All gRPC threads that read commands get this priority. They inherit it.
  MakeWithRealtimeThreads(kReadingPriority, [&] { parts_->Build(tls); });
  if (!parts_->server) throw std::runtime_error("cannot serve on " + address);
  parts_->acceptor.emplace(parts_->endpoint, HandOnTo(parts_->connections.get()),
                           Acceptor::Limits{.burst = BurstOf(slave)});
  parts_->endpoint = parts_->acceptor->endpoint();
  parts_->address = ToString(parts_->endpoint);
  parts_->acceptor->Start();
  parts_->UpdateHealth();  // before it, the service is unknown
  parts_->health =
      std::jthread([this](const std::stop_token& stop) { parts_->KeepHealthUpdated(stop); });
}

Server::~Server() {
  Stop();
}

void Server::PublishOn(const NatsServer& nats) {
  parts_->feed.emplace(nats, parts_->slave, parts_->publisher, parts_->service);
}

const std::string& Server::address() const {
  return parts_->address;
}

void Server::Stop(std::chrono::milliseconds grace) {
  std::call_once(parts_->stopped, [&] {
    parts_->health = {};
    parts_->acceptor->Stop();
    parts_->server->GetHealthCheckService()->Shutdown();
    parts_->publisher.Stop();
    parts_->feed.reset();
    parts_->service.EndStreams();
    parts_->server->Shutdown(std::chrono::system_clock::now() + grace);
    parts_->server->Wait();
  });
}

}  // namespace palpate
