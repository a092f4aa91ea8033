#include "slave/commands/health/health.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "shared/link/loopback.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"
#include "slave/commands/program.h"

namespace palpate {
namespace {

// HealthCheckRequest {service = 1} and HealthCheckResponse {status = 1: SERVING} of
// grpc.health.v1, which Debian's gRPC brings without their generated code.
constexpr std::string_view kMethod = "/grpc.health.v1.Health/Check";
constexpr std::string_view kRequest = "\x0A\x18palpate.v1.Teleoperation";
constexpr std::string_view kServing = "\x08\x01";

std::string ContentOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  buffer.Dump(&slices);
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

// Describes the program that answers at `endpoint` in place of a slave.
std::string WhatAnswers(const Endpoint& endpoint) {
  constexpr timeval kTimeout{1, 0};
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(endpoint.host.c_str(), std::to_string(endpoint.port).c_str(), &hints, &found) !=
      0) {
    return "the name " + Shown(endpoint.host) + " has no address";
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owned(found, freeaddrinfo);
  const int socket = ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return "no connection";
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &kTimeout, sizeof kTimeout);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &kTimeout, sizeof kTimeout);
  std::string words = "nothing listens there";
  if (connect(socket, found->ai_addr, found->ai_addrlen) == 0) {
    constexpr std::string_view kGet = "GET / HTTP/1.0\r\n\r\n";
    std::array<char, 5> answer{};
    const bool is_web = send(socket, kGet.data(), kGet.size(), MSG_NOSIGNAL) > 0 &&
                        recv(socket, answer.data(), answer.size(), MSG_WAITALL) == answer.size() &&
                        std::string_view(answer.data(), answer.size()) == "HTTP/";
    words = is_web ? "a web server answers there, no palpate slave"
                   : "another program answers there, or a slave with TLS where --tls is missing "
                     "(or the reverse)";
  }
  close(socket);
  return words;
}

}  // namespace

int RunHealth(const HealthOptions& options) {
  const Endpoint endpoint = ParseEndpoint(options.target);
  RequireLoopbackUnless(options.insecure || !options.tls.empty(), endpoint);
  const auto credentials =
      options.tls.empty() ? grpc::InsecureChannelCredentials() : ChannelTls(options.tls);
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  grpc::GenericStub stub(grpc::CreateCustomChannel(ToString(endpoint), credentials, arguments));
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::milliseconds(static_cast<int>(1e3 * options.wait)));
  grpc::CompletionQueue queue;
  const grpc::Slice request(kRequest.data(), kRequest.size());
  const auto call =
      stub.PrepareUnaryCall(&context, std::string(kMethod), grpc::ByteBuffer(&request, 1), &queue);
  call->StartCall();
  grpc::ByteBuffer answer;
  grpc::Status status;
  call->Finish(&answer, &status, &answer);
  void* done = nullptr;
  bool ok = false;
  queue.Next(&done, &ok);
  if (!status.ok()) {
    throw std::runtime_error("health: " + options.target + ": no answer of a slave in " +
                             Formatted("%g s: ", options.wait) + WhatAnswers(endpoint));
  }
  const bool is_serving = ContentOf(answer) == kServing;
  std::puts(is_serving ? "SERVING" : "NOT_SERVING");
  return is_serving ? 0 : kFailed;
}

}  // namespace palpate
