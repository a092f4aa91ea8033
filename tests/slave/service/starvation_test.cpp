// Tests which resources one client may use up; the emergency stop must always work.
#include <memory>
#include <string>
#include <vector>

#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

class StarvationTest : public ServiceTest {
 protected:
  grpc::StatusCode Stop() const {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kLiveness);
    v1::Status reply;
    return Connect()->Stop(&context, {}, &reply).error_code();
  }
};

// Silent streams of the reflection service, each of which occupies a thread of the pool.
class IdleStreams {
 public:
  IdleStreams(const std::string& address, int count) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    stub_ = std::make_unique<grpc::GenericStub>(
        grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
    for (int i = 0; i < count; ++i) {
      contexts_.push_back(std::make_unique<grpc::ClientContext>());
      calls_.push_back(stub_->PrepareCall(
          contexts_.back().get(), "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
          &queue_));
      calls_.back()->StartCall(this);
    }
    for (int i = 0; i < count; ++i) Next();
  }
  ~IdleStreams() {
    for (const auto& context : contexts_) context->TryCancel();
    std::vector<grpc::Status> statuses(calls_.size());
    for (std::size_t i = 0; i < calls_.size(); ++i) calls_[i]->Finish(&statuses[i], this);
    for (std::size_t i = 0; i < calls_.size(); ++i) Next();
  }

 private:
  void Next() {
    void* tag = nullptr;
    bool ok = false;
    queue_.Next(&tag, &ok);
  }

  std::unique_ptr<grpc::GenericStub> stub_;
  grpc::CompletionQueue queue_;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts_;
  std::vector<std::unique_ptr<grpc::GenericClientAsyncReaderWriter>> calls_;
};

TEST_F(StarvationTest, IdleStreamsDoNotBlockTheStop) {
  const IdleStreams one(server_->address(), 70), other(server_->address(), 70);
  EXPECT_EQ(Stop(), grpc::StatusCode::OK);
  EXPECT_EQ(GetStatus().phase(), v1::PHASE_ESTOP);
  Operator ada(Connect());
  ada.Hold(0);
  EXPECT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 1; }));
}

// A model that never completes: no other call waits for it, and it ends with its call.
TEST_F(StarvationTest, ModelsAreMadeOneAtATimeAndEndWithTheirCall) {
  slave_.MakeModelsForEver();
  grpc::ClientContext first;
  grpc::Status first_status;
  std::jthread asking([&] {
    v1::SettingsReply reply;
    first_status = Connect()->SetModel(&first, {}, &reply);
  });
  ASSERT_TRUE(Eventually([&] { return slave_.is_making(); }));
  for (int i = 0; i < 150; ++i) {
    CallContext context;
    v1::SettingsReply reply;
    ASSERT_EQ(Connect()->SetModel(&context, {}, &reply).error_code(), grpc::StatusCode::ABORTED);
  }
  EXPECT_EQ(Stop(), grpc::StatusCode::OK);
  EXPECT_TRUE(slave_.is_making());
  first.TryCancel();
  asking.join();
  EXPECT_EQ(first_status.error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(Eventually([&] { return !slave_.is_making(); }));
}

// Images are encoded once for all observers with the same parameters.
TEST_F(StarvationTest, WatchersShareAnEncoding) {
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::ImageState>>> readers;
  const auto stub = Connect();
  slave_.TakeSample();
  const int before = slave_.images_taken();
  for (int i = 0; i < 8; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    SetDeadline(contexts.back().get());
    readers.push_back(stub->WatchImages(contexts.back().get(), {}));
  }
  v1::ImageState frame;
  for (const auto& reader : readers) ASSERT_TRUE(reader->Read(&frame));
  EXPECT_LE(slave_.images_taken() - before, 3) << "nothing seen yet, then one image";
  for (const auto& context : contexts) context->TryCancel();
}

}  // namespace
}  // namespace palpate
