#include "slave/commands/health/health.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <vector>

#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>

#include "shared/link/loopback.h"
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
    throw std::runtime_error("health: " + options.target + ": " + status.error_message());
  }
  const bool is_serving = ContentOf(answer) == kServing;
  std::puts(is_serving ? "SERVING" : "NOT_SERVING");
  return is_serving ? 0 : kFailed;
}

}  // namespace palpate
