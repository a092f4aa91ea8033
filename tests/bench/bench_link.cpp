// State latency slave -> master over loopback, against bare gRPC with messages of the same size in
// the same run.
//
//   state     something is sensed in a FakeSlave -> publisher -> Operate -> stamp in the master's
//             reader; what comes after that stamp, reading the message and putting it into the
//             haptic loop's slot, is the row `unpack`
//   one-way   the bare floor: a blocking handler stamps a message and writes it, a blocking reader
//             stamps it; no publisher, no mailbox, no other thread
//   echo      a bare bidirectional stream: a command up, a state down, both ways together
//
// All at 500 Hz, in blocks of one second that take turns, so that what the machine does besides
// falls on all alike. p50 and p99 are medians over the blocks. Exit code 1: above the floor.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <thread>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/slave_link.h"
#include "shared/wire/state_message.h"
#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"

namespace palpate {
namespace {

constexpr double kFloor = 2.0;  // of the ratio to the bare one-way stream
constexpr int kBlocks = 15, kPerBlock = 500;
constexpr std::chrono::milliseconds kPeriod(2);

double MicrosSince(const google::protobuf::Timestamp& stamp) {
  const auto then = std::chrono::seconds(stamp.seconds()) + std::chrono::nanoseconds(stamp.nanos());
  return 1e6 * SecondsBetween(Time(then), Clock::now());
}

// A state of the size that a contact really has.
SlaveState TypicalState() {
  FakeSlave slave;
  slave.TakeSample();
  SlaveState state = slave.Compose(Clock::now());
  state.sequence = state.command_sequence = 100'000;
  state.echo = state.sent_at;
  return state;
}

void Stamp(google::protobuf::Timestamp* stamp) {
  const auto now = Clock::now().time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now);
  stamp->set_seconds(seconds.count());
  stamp->set_nanos(static_cast<int>((now - seconds).count()));
}

// gRPC and nothing else.
class BareService final : public v1::Teleoperation::Service {
 public:
  grpc::Status WatchState(grpc::ServerContext* context, const v1::WatchStateRequest* /*request*/,
                          grpc::ServerWriter<v1::SlaveState>* writer) override {
    v1::SlaveState message;
    ToProto(TypicalState(), &message);
    for (auto wake = Clock::now(); !context->IsCancelled(); wake += kPeriod) {
      std::this_thread::sleep_until(Clock::ToSteady(wake));
      Stamp(message.mutable_sensed_at());
      if (!writer->Write(message)) break;
    }
    return grpc::Status::OK;
  }
  grpc::Status Operate(
      grpc::ServerContext* /*context*/,
      grpc::ServerReaderWriter<v1::SlaveState, v1::OperatorCommand>* stream) override {
    v1::SlaveState message;
    ToProto(TypicalState(), &message);
    v1::OperatorCommand command;
    while (stream->Read(&command)) stream->Write(message);
    return grpc::Status::OK;
  }
};

using Samples = std::vector<double>;  // [us]

class BareLink {
 public:
  BareLink() {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    stub_ = v1::Teleoperation::NewStub(grpc::CreateChannel("127.0.0.1:" + std::to_string(port),
                                                           grpc::InsecureChannelCredentials()));
  }
  Samples OneWay() {
    grpc::ClientContext context;
    const auto stream = stub_->WatchState(&context, {});
    Samples samples;
    v1::SlaveState message;
    while (samples.size() < kPerBlock && stream->Read(&message)) {
      samples.push_back(MicrosSince(message.sensed_at()));
    }
    context.TryCancel();
    return samples;
  }
  Samples Echo() {
    grpc::ClientContext context;
    const auto stream = stub_->Operate(&context);
    Samples samples;
    v1::OperatorCommand command;
    command.mutable_p_m()->set_y(1);
    v1::SlaveState message;
    for (auto wake = Clock::now(); samples.size() < kPerBlock; wake += kPeriod) {
      std::this_thread::sleep_until(Clock::ToSteady(wake));
      const Time start = Clock::now();
      stream->Write(command);
      stream->Read(&message);
      samples.push_back(1e6 * SecondsBetween(start, Clock::now()));
    }
    context.TryCancel();
    return samples;
  }

 private:
  BareService service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<v1::Teleoperation::Stub> stub_;
};

// What Palpate sends and receives; commands go up at the same time, as they do in use.
class PalpateLink {
 public:
  Samples States() {
    Server server(slave_, "127.0.0.1:0", false);
    LatestValue<ReceivedState> states;
    LatestValue<OperatorCommand> commands;
    LatestValue<RemoteSettings> settings;
    SlaveLink::Options options;
    options.target = server.address();
    SlaveLink link(options);
    link.Start(&states, &commands, &settings);
    Samples samples;
    OperatorCommand command;
    Time newest{};
    for (auto wake = Clock::now(); samples.size() < kPerBlock; wake += kPeriod) {
      std::this_thread::sleep_until(Clock::ToSteady(wake));
      if (const ReceivedState* state = states.Take(); state && state->state.sensed_at > newest) {
        newest = state->state.sensed_at;
        samples.push_back(1e6 * SecondsBetween(newest, state->received_at));
      }
      ++command.sequence;
      commands.Put(command);
      slave_.TakeSample();
    }
    return samples;
  }

 private:
  FakeSlave slave_;
};

Samples Unpack() {
  v1::SlaveState message;
  ToProto(TypicalState(), &message);
  LatestValue<ReceivedState> slot;
  Samples samples;
  std::string reason;
  for (int i = 0; i < kPerBlock; ++i) {
    const Time start = Clock::now();
    slot.Put({*FromProto(message, &reason), start, 0});
    samples.push_back(1e6 * SecondsBetween(start, Clock::now()));
  }
  return samples;
}

double Quantile(Samples values, double q) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Row {
  const char* name;
  std::function<Samples()> measure;
  Samples p50{}, p99{}, max{};

  void MeasureBlock() {
    const Samples samples = measure();
    p50.push_back(Quantile(samples, 0.5));
    p99.push_back(Quantile(samples, 0.99));
    max.push_back(Quantile(samples, 1));
  }
  double P50() const { return Quantile(p50, 0.5); }
  double P99() const { return Quantile(p99, 0.5); }
};

int Run() {
  BareLink bare;
  PalpateLink palpate;
  std::vector<Row> rows{{"state", [&] { return palpate.States(); }},
                        {"one-way", [&] { return bare.OneWay(); }},
                        {"echo", [&] { return bare.Echo(); }},
                        {"unpack", Unpack}};
  for (int block = 0; block < kBlocks; ++block) {
    for (Row& row : rows) row.MeasureBlock();
  }
  v1::SlaveState message;
  ToProto(TypicalState(), &message);
  std::printf("state of %zu bytes, 500 Hz, %d blocks of %d [us]\n%-8s %8s %8s %8s %14s %14s\n",
              message.ByteSizeLong(), kBlocks, kPerBlock, "", "p50", "p99", "max", "state/it p50",
              "state/it p99");
  for (const Row& row : rows) {
    std::printf("%-8s %8.1f %8.1f %8.1f %14.2f %14.2f\n", row.name, row.P50(), row.P99(),
                Quantile(row.max, 1), rows[0].P50() / row.P50(), rows[0].P99() / row.P99());
  }
  const double worst = std::max(rows[0].P50() / rows[1].P50(), rows[0].P99() / rows[1].P99());
  std::printf("worst ratio to the bare one-way stream: %.2f, at most %.1f accepted\n", worst,
              kFloor);
  return worst <= kFloor ? 0 : 1;
}

}  // namespace
}  // namespace palpate

int main() {
  return palpate::Run();
}
