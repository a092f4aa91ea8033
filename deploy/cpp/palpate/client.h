// Client of a Palpate slave:
//
//   palpate::Slave slave("127.0.0.1:50051");
//   slave.Watch([](const palpate::State& state) {
//     if (state.valid()) std::cout << state.force()[1] << " N\n";
//     return true;  // go on
//   });
//
// Points and forces are in SI units, in the frame S of the slave. Every call throws Error if the
// slave rejects it or cannot be reached.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>

#include <grpcpp/grpcpp.h>
#include <palpate/v1/teleoperation.grpc.pb.h>

#include "palpate/arm.h"
#include "palpate/operator.h"
#include "palpate/state.h"

namespace palpate {
// Its symbols are not those of the programs, whose classes have some of the same names.
inline namespace client {

// A connected slave. `stub()` has all calls of palpate.v1, for what this class does not offer.
class Slave {
 public:
  // HOST:PORT in plain text, or with ca.pem, cert.pem and key.pem of the folder `tls`.
  explicit Slave(const std::string& address, const std::filesystem::path& tls = {}) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    // A link that is cut is silent: without keepalive a stream on it would wait for ever. After 1 s
    // without data the client sends a ping, and after 10 s without its answer every call ends.
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 1000);
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10000);
    arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    stub_ =
        v1::Teleoperation::NewStub(grpc::CreateCustomChannel(address, Credentials(tls), arguments));
  }

  [[nodiscard]] v1::Teleoperation::Stub& stub() const noexcept { return *stub_; }
  // What is modelled, and in `capabilities` workspace, degrees of freedom, rates and limits.
  [[nodiscard]] v1::SceneDescription Scene() const {
    return Request<v1::SceneDescription>(&v1::Teleoperation::Stub::GetScene, v1::GetSceneRequest());
  }
  // Phase, validity, operator, rates and alarms.
  [[nodiscard]] v1::Status Status() const {
    return Request<v1::Status>(&v1::Teleoperation::Stub::GetStatus, v1::GetStatusRequest());
  }
  // Emergency stop, latched until Reset.
  v1::Status Stop(const std::string& reason) const {
    v1::StopRequest request;
    request.set_reason(reason);
    return Request<v1::Status>(&v1::Teleoperation::Stub::Stop, request);
  }
  // Clears the emergency stop that `known` shows, as in `Reset(Status())`. A stop that was
  // requested after `known` stays, and the call throws. While nothing is stopped, tool, object and
  // baseline are detected again.
  v1::Status Reset(const v1::Status& known = {}) const {
    v1::ResetRequest request;
    request.set_stops(known.stops());
    return Request<v1::Status>(&v1::Teleoperation::Stub::Reset, request);
  }

  // Calls `on_state` with the newest state, at most `rate` times per second [Hz] (0: every new
  // one), until it returns false. Needs no lease and cannot move the tool.
  void Watch(const std::function<bool(const State&)>& on_state, double rate = 0) const {
    v1::WatchStateRequest request;
    request.set_max_rate(rate);
    grpc::ClientContext context;
    const auto stream = stub_->WatchState(&context, request);
    v1::SlaveState message;
    while (stream->Read(&message)) {
      if (on_state(State(message))) continue;
      context.TryCancel();
      return;
    }
    Require(stream->Finish());
  }

  // Takes the lease under `name`. Throws LeaseHeld if another client has it.
  [[nodiscard]] std::unique_ptr<Operator> Operate(const std::string& name) const {
    return std::make_unique<Operator>(stub_.get(), name);
  }

  // Sends what `next` returns until it returns nothing. The scene's camera needs `source: stream`.
  v1::FeedImagesReply FeedImages(
      const std::function<std::optional<v1::ImageSample>()>& next) const {
    return Feed<v1::FeedImagesReply>(&v1::Teleoperation::Stub::FeedImages, next);
  }
  // The same for readings of fingertips. Returns how many were accepted.
  std::uint64_t FeedFingertips(
      const std::function<std::optional<v1::TactileSample>()>& next) const {
    return Feed<v1::FeedTactileReply>(&v1::Teleoperation::Stub::FeedTactile, next).samples();
  }

  // Drives `arm` with `rate` reports per second [Hz] until `seconds` have passed or the slave ends.
  // The scene needs `manipulator: {source: stream}`.
  Exchange Drive(Arm& arm, double rate, double seconds, const std::string& name) const {
    return ArmDriver(arm, rate, seconds, name).Run(stub_.get());
  }

 private:
  static std::shared_ptr<grpc::ChannelCredentials> Credentials(const std::filesystem::path& tls) {
    if (tls.empty()) return grpc::InsecureChannelCredentials();
    const auto read = [&](const char* name) {
      std::ifstream file(tls / name);
      if (!file) throw std::runtime_error((tls / name).string() + ": cannot be read");
      return std::string(std::istreambuf_iterator<char>(file), {});
    };
    return grpc::SslCredentials({read("ca.pem"), read("key.pem"), read("cert.pem")});
  }
  static void Require(const grpc::Status& status) {
    if (!status.ok()) throw Error(status);
  }
  template <typename Reply, typename Call, typename Message>
  Reply Request(Call call, const Message& request) const {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
    Reply reply;
    Require((stub_.get()->*call)(&context, request, &reply));
    return reply;
  }
  template <typename Reply, typename Call, typename Next>
  Reply Feed(Call call, const Next& next) const {
    grpc::ClientContext context;
    Reply reply;
    const auto stream = (stub_.get()->*call)(&context, &reply);
    while (const auto sample = next()) {
      if (!stream->Write(*sample)) break;  // the slave rejected a sample: Finish says why
    }
    stream->WritesDone();
    Require(stream->Finish());
    return reply;
  }

  std::unique_ptr<v1::Teleoperation::Stub> stub_;
};

}  // namespace client
}  // namespace palpate
