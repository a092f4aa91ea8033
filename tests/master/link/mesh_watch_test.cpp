// The watch of the object's shape against a real server with a fake slave behind it, and against a
// peer that says what it is told.
#include "master/link/mesh_watch.h"

#include <atomic>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using testing::HasSubstr;

MeshWatch::Options To(const std::string& target) {
  MeshWatch::Options options;
  options.target = target;
  options.rate = 120;
  return options;
}

class MeshWatchTest : public testing::Test {
 protected:
  template <class Condition>
  bool SensingUntil(const Condition& condition) {
    return Eventually([&] {
      slave_.TakeSample();
      return condition();
    });
  }

  FakeSlave slave_;
  std::unique_ptr<Server> server_ = std::make_unique<Server>(slave_, "127.0.0.1:0", false);
};

// Reference: the fake's triangle, whose first corner is half a metre from its place.
TEST_F(MeshWatchTest, TheNewestMeshIsThereAndNobodyComputesItForNobody) {
  slave_.TakeSample();
  EXPECT_EQ(slave_.shapes_computed(), 0);
  MeshWatch watch(To(server_->address()));
  ASSERT_TRUE(SensingUntil([&] { return watch.stats().meshes > 2; }));
  const auto mesh = watch.newest();
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->positions.size(), 3U);
  EXPECT_EQ(mesh->LargestDeflection(), 0.5);
  EXPECT_TRUE(mesh->nodal_forces.empty());
  EXPECT_EQ(watch.stats().deflection_peak, 0.5);
  EXPECT_EQ(watch.stats().trouble, "");
  watch.Stop();
  const int computed = slave_.shapes_computed();
  for (int i = 0; i < 20; ++i) {
    slave_.TakeSample();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_LE(slave_.shapes_computed(), computed + 1) << "one may have been on its way";
  EXPECT_EQ(watch.newest(), mesh) << "the last one stays";
}

TEST_F(MeshWatchTest, NodalForcesComeIfAskedFor) {
  MeshWatch::Options options = To(server_->address());
  options.nodal_forces = true;
  const MeshWatch watch(options);
  ASSERT_TRUE(SensingUntil([&] { return watch.newest() != nullptr; }));
  EXPECT_EQ(watch.newest()->nodal_forces.size(), 3U);
}

TEST_F(MeshWatchTest, ItComesBackWithTheSlave) {
  const std::string address = server_->address();
  const MeshWatch watch(To(address));
  ASSERT_TRUE(SensingUntil([&] { return watch.stats().meshes > 0; }));
  server_.reset();
  ASSERT_TRUE(Eventually([&] { return !watch.stats().trouble.empty(); }));
  EXPECT_TRUE(watch.newest()) << "what was seen last";
  server_ = std::make_unique<Server>(slave_, address, false);
  const std::uint64_t before = watch.stats().meshes;
  ASSERT_TRUE(SensingUntil([&] { return watch.stats().meshes > before; }));
  EXPECT_EQ(watch.stats().trouble, "");
}

TEST_F(MeshWatchTest, PlainTextLeavesThisMachineOnlyOnRequest) {
  EXPECT_THROW(MeshWatch(To("192.0.2.1:5")), std::invalid_argument);
}

TEST_F(MeshWatchTest, StopsAtOnceWhereNobodyIsAndTwiceIsFine) {
  const std::string address = server_->address();
  server_.reset();
  MeshWatch watch(To(address));
  ASSERT_TRUE(Eventually([&] { return !watch.stats().trouble.empty(); }));
  EXPECT_EQ(watch.newest(), nullptr);
  watch.Stop();
  watch.Stop();
}

// Sends `messages` and then silence.
class FakeMeshServer final : public v1::Teleoperation::Service {
 public:
  explicit FakeMeshServer(std::vector<v1::MeshState> messages) : messages_(std::move(messages)) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address = "127.0.0.1:" + std::to_string(port);
  }
  grpc::Status WatchMesh(grpc::ServerContext* context, const v1::WatchMeshRequest* request,
                         grpc::ServerWriter<v1::MeshState>* writer) override {
    asked_rate = request->max_rate_hz();
    for (const auto& message : messages_) writer->Write(message);
    while (!context->IsCancelled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return grpc::Status::CANCELLED;
  }

  std::string address;
  std::atomic<double> asked_rate{0};

 private:
  std::vector<v1::MeshState> messages_;
  std::unique_ptr<grpc::Server> server_;
};

// A surface too large for gRPC's default of 4 MB a message comes whole.
TEST_F(MeshWatchTest, LargeMeshesCome) {
  constexpr int kNodes = 500'000;
  v1::MeshState message;
  message.mutable_sensed_at();
  message.set_nodes_per_element(2);
  for (int i = 0; i < kNodes; ++i) {
    for (int axis = 0; axis < 3; ++axis) message.add_rest(static_cast<float>(i));
  }
  message.mutable_positions()->CopyFrom(message.rest());
  FakeMeshServer teller({message});
  const MeshWatch watch(To(teller.address));
  ASSERT_TRUE(Eventually([&] { return watch.stats().meshes > 0; }));
  EXPECT_EQ(watch.newest()->positions.size(), static_cast<std::size_t>(kNodes));
  EXPECT_EQ(teller.asked_rate, 120);
}

TEST_F(MeshWatchTest, MeshesThatCannotBeAreCountedToldAndNeverHandedOn) {
  v1::MeshState headless;
  headless.mutable_sensed_at();
  for (int i = 0; i < 3; ++i) headless.add_positions(0);
  FakeMeshServer teller({headless, headless});
  const MeshWatch watch(To(teller.address));
  ASSERT_TRUE(Eventually([&] { return watch.stats().refused == 2; }));
  EXPECT_EQ(watch.newest(), nullptr);
  EXPECT_THAT(watch.stats().trouble, HasSubstr("a mesh was rejected: rest is absent"));
}

}  // namespace
}  // namespace palpate
