#include "slave/service/server.h"

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <netdb.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include "shared/link/loopback.h"
#include "shared/tls/credentials.h"
#include "slave/service/listener_watch.h"
#include "slave/service/publisher.h"
#include "slave/service/roles.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr int kMaxRequestBytes = 64 * 1024;
constexpr int kMaxStreamsPerConnection = 2 * ObserverSeats::kSeats;
constexpr int kMaxThreads = 2 * ObserverSeats::kSeats;
constexpr int kShortestPingMs = 500;  // masters may ask this often whether we live
constexpr std::chrono::milliseconds kHealthPeriod(50);
constexpr std::chrono::milliseconds kGrace(300);  // for streams to end by themselves

[[noreturn]] void Refuse(const Endpoint& endpoint, const std::string& why) {
  throw std::runtime_error("cannot listen on " + ToString(endpoint) + ": " + why);
}

// 0, or errno of the step that failed. The socket is gone when it returns.
int TryListening(const addrinfo& address) {
  const int fd = socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return errno;
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);  // as gRPC does: not while in use
  if (address.ai_family == AF_INET6) setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &on, sizeof on);
  const bool works = bind(fd, address.ai_addr, address.ai_addrlen) == 0 && listen(fd, 1) == 0;
  const int error = works ? 0 : errno;
  close(fd);
  return error;
}

// Throws std::runtime_error: host unknown, port in use, not an address of this machine, not
// permitted. Asked of the operating system: gRPC only says that it failed.
void RequireListenable(const Endpoint& endpoint) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(endpoint.port);
  const int error = getaddrinfo(endpoint.host.c_str(), port.c_str(), &hints, &found);
  if (error != 0) Refuse(endpoint, gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  int last = 0;
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    last = TryListening(*address);
    if (last == EADDRINUSE) break;  // in use in one family is in use
    if (last == 0) return;
  }
  Refuse(endpoint, std::strerror(last));
}

Endpoint Permitted(const std::string& address, bool insecure) {
  try {
    const Endpoint endpoint = ParseEndpoint(address);
    RequireLoopbackUnless(insecure, endpoint);
    RequireListenable(endpoint);
    return endpoint;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
  }
}

// gRPC logs each handshake that fails, as that of the watch does.
ListenerWatch::Options Rarely() {
  return {.period = std::chrono::seconds(60)};
}

std::shared_ptr<grpc::ServerCredentials> CredentialsFrom(const std::filesystem::path& tls) {
  if (tls.empty()) return grpc::InsecureServerCredentials();
  auto credentials = ServerTls(tls);
  credentials->SetAuthMetadataProcessor(RoleCheck());
  return credentials;
}

void Configure(grpc::ServerBuilder* builder) {
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreamsPerConnection);
  // No keepalive of ours: gRPC 1.51 aborts where its timer meets a connection that closes. Lease
  // and watchdog notice a line that was cut.
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                              kShortestPingMs);
  builder->SetMaxReceiveMessageSize(kMaxRequestBytes);
  builder->SetResourceQuota(grpc::ResourceQuota("palpate").SetMaxThreads(kMaxThreads));
}

}  // namespace

// A deaf listener in a living process is worse than none: whoever supervises starts it anew.
void EndProcess() {
  spdlog::critical("nobody can connect any more: ending, to be started anew");
  std::_Exit(EXIT_FAILURE);
}

struct Server::Parts {
  Parts(Slave& served, Endpoint listen_on)
      : slave(served),
        endpoint(std::move(listen_on)),
        publisher(slave),
        service(slave, publisher) {}

  // Health follows what is sensed.
  void Tell() const;
  void KeepTelling(const std::stop_token& stop) const;

  Slave& slave;
  Endpoint endpoint;
  std::string address;
  Publisher publisher;
  TeleoperationService service;
  std::unique_ptr<grpc::Server> server;
  std::once_flag stopped;
  std::optional<ListenerWatch> listener;
  std::jthread telling;
};

void Server::Parts::Tell() const {
  const bool fresh = slave.Status().validity != Validity::kStale;
  server->GetHealthCheckService()->SetServingStatus(v1::Teleoperation::service_full_name(), fresh);
}

void Server::Parts::KeepTelling(const std::stop_token& stop) const {
  for (; !stop.stop_requested(); std::this_thread::sleep_for(kHealthPeriod)) Tell();
}

Server::Server(Slave& slave, const std::string& address, bool insecure,
               const std::filesystem::path& tls, std::function<void()> on_deaf)
    : parts_(std::make_unique<Parts>(slave, Permitted(address, insecure || !tls.empty()))) {
  const auto credentials = CredentialsFrom(tls);
  grpc::EnableDefaultHealthCheckService(true);
  // Each of its streams holds a thread: for those on this machine.
  if (IsLoopback(parts_->endpoint.host)) {
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  }
  grpc::ServerBuilder builder;
  Configure(&builder);
  int port = 0;
  builder.AddListeningPort(ToString(parts_->endpoint), credentials, &port);
  builder.RegisterService(&parts_->service);
  parts_->server = builder.BuildAndStart();
  if (!parts_->server || port <= 0) throw std::runtime_error("cannot listen on " + address);
  parts_->endpoint.port = static_cast<std::uint16_t>(port);
  parts_->address = ToString(parts_->endpoint);
  parts_->Tell();  // nobody finds a service that is unknown
  parts_->telling =
      std::jthread([this](const std::stop_token& stop) { parts_->KeepTelling(stop); });
  parts_->listener.emplace(parts_->endpoint, on_deaf ? std::move(on_deaf) : EndProcess,
                           tls.empty() ? ListenerWatch::Options() : Rarely());
}

Server::~Server() {
  Stop();
}

const std::string& Server::address() const {
  return parts_->address;
}

void Server::Stop() {
  std::call_once(parts_->stopped, [this] {
    parts_->listener.reset();
    parts_->telling = {};
    parts_->server->GetHealthCheckService()->Shutdown();
    parts_->publisher.Stop();
    parts_->service.EndStreams();
    parts_->server->Shutdown(std::chrono::system_clock::now() + kGrace);
    parts_->server->Wait();
  });
}

}  // namespace palpate
