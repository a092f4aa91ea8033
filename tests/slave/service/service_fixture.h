// A FakeSlave behind a real server on a free port, and helpers for clients.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"
#include "tests/support/eventually.h"

namespace palpate {

inline void SetDeadline(grpc::ClientContext* context) {
  context->set_deadline(std::chrono::system_clock::now() + kLiveness);
}

// Deadline of a call in tests.
struct CallContext : grpc::ClientContext {
  CallContext() { SetDeadline(this); }
};

// Matches the status of a call that ended with this code and a message that `words` matches.
MATCHER_P2(EndedWith, code, words, "") {
  *result_listener << arg.error_code() << ": " << arg.error_message();
  return arg.error_code() == code && testing::Value(arg.error_message(), words);
}

class ServiceTest : public testing::Test {
 protected:
  // Returns a stub with a separate connection.
  std::unique_ptr<v1::Teleoperation::Stub> Connect(grpc::ChannelArguments arguments = {}) const {
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    return v1::Teleoperation::NewStub(grpc::CreateCustomChannel(
        server_->address(), grpc::InsecureChannelCredentials(), arguments));
  }
  // Returns a stub with a small receive window.
  std::unique_ptr<v1::Teleoperation::Stub> ConnectWithSmallWindow() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 1024);
    return Connect(arguments);
  }

  v1::Status GetStatus() const {
    CallContext context;
    v1::Status status;
    EXPECT_TRUE(Connect()->GetStatus(&context, {}, &status).ok());
    return status;
  }

  FakeSlave slave_;
  std::unique_ptr<Server> server_ = std::make_unique<Server>(slave_, "127.0.0.1:0", false);
};

// The client side of an operator's stream.
class Operator {
 public:
  explicit Operator(std::unique_ptr<v1::Teleoperation::Stub> stub) : stub_(std::move(stub)) {
    SetDeadline(&context_);
    stream_ = stub_->Operate(&context_);
  }
  bool Send(const v1::OperatorCommand& command) { return stream_->Write(command); }
  // Sends a good command that holds the tool `y` [m] from where it was engaged.
  bool Hold(double y, const std::string& name = "") {
    v1::OperatorCommand command;
    command.set_sequence(++sequence_);
    command.mutable_sent_at()->set_seconds(1'700'000'000);
    command.set_epoch(1);
    command.mutable_p_m()->set_y(y);
    command.set_engaged(true);
    command.set_operator_name(name);
    return Send(command);
  }
  std::optional<v1::SlaveState> Read() {
    v1::SlaveState state;
    return stream_->Read(&state) ? std::optional(state) : std::nullopt;
  }
  // The same connection for other calls.
  v1::Teleoperation::Stub& stub() { return *stub_; }
  // Reads until `wanted` holds for a state; nullopt: the stream ended first.
  std::optional<v1::SlaveState> ReadUntil(
      const std::function<bool(const v1::SlaveState&)>& wanted) {
    auto state = Read();
    while (state && !wanted(*state)) state = Read();
    return state;
  }
  // Simulates a terminated program: nothing more is sent or read.
  void Vanish() { context_.TryCancel(); }
  // Reads to the end.
  grpc::Status Finish() {
    while (Read()) {
    }
    return stream_->Finish();
  }
  grpc::Status Leave() {
    stream_->WritesDone();
    return Finish();
  }

 private:
  std::unique_ptr<v1::Teleoperation::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::OperatorCommand, v1::SlaveState>> stream_;
  std::uint64_t sequence_ = 0;
};

inline bool HasEvent(const v1::SlaveState& state, v1::Event event) {
  return std::count(state.events().begin(), state.events().end(), event) > 0;
}

}  // namespace palpate
