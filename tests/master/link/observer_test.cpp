// The observer against a real server with a fake slave behind it, and against a peer that sends
// given messages.
#include "master/link/observer.h"

#include <atomic>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <google/protobuf/message.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/slave_link.h"
#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using User = Observer::User;

constexpr ObservedViews kMeshes{.mesh_rate = 120}, kImages{.image_rate = 120};

SlaveLink::Options To(const std::string& target) {
  return {.target = target};
}

class ObserverTest : public testing::Test {
 protected:
  [[nodiscard]] SlaveLink::Options Line() const { return To(server_->address()); }
  // Takes samples until `condition`.
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

// Reference: the fake's triangle, whose first corner is displaced by half a metre.
TEST_F(ObserverTest, MeshesAreComputedOnlyWhileTheyAreRead) {
  slave_.TakeSample();
  EXPECT_EQ(slave_.shapes_computed(), 0);
  Observer observer(To(server_->address()), {});
  observer.Need(User::kTable, kMeshes);
  ASSERT_TRUE(SensingUntil([&] { return observer.mesh_stats().meshes > 2; }));
  const auto mesh = observer.mesh();
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->positions.size(), 3U);
  EXPECT_EQ(mesh->LargestDeflection(), 0.5);
  EXPECT_TRUE(mesh->nodal_forces.empty());
  EXPECT_EQ(observer.mesh_stats().deflection_peak, 0.5);
  EXPECT_EQ(observer.mesh_stats().trouble, "");
  observer.Need(User::kTable, {});
  int computed = slave_.shapes_computed(), samples_without = 0;
  EXPECT_TRUE(Eventually([&] {  // the slave notices the end of the stream later
    slave_.TakeSample();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const int before = std::exchange(computed, slave_.shapes_computed());
    samples_without = computed == before ? samples_without + 1 : 0;
    return samples_without == 20;
  })) << "meshes are computed for nobody";
  ASSERT_TRUE(observer.mesh());
  EXPECT_EQ(observer.mesh()->LargestDeflection(), 0.5) << "the last one stays";
}

TEST_F(ObserverTest, StopsAtOnceWithoutASlaveAndMayBeStoppedTwice) {
  const std::string address = server_->address();
  server_.reset();
  Observer observer(To(address), {});
  observer.Need(User::kTable, kMeshes);
  ASSERT_TRUE(Eventually([&] { return !observer.mesh_stats().trouble.empty(); }));
  EXPECT_EQ(observer.mesh(), nullptr);
  observer.Need(User::kTable, {});
  observer.Need(User::kTable, {});
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
    asked_rate = request->max_rate();
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

// A surface larger than gRPC's default limit of 4 MB per message is received completely.
TEST_F(ObserverTest, LargeMeshesCome) {
  constexpr int kNodes = 500'000;
  v1::MeshState message;
  message.mutable_sensed_at();
  message.set_nodes_per_element(2);
  for (int i = 0; i < kNodes; ++i) {
    for (int axis = 0; axis < 3; ++axis) message.add_rest(static_cast<float>(i));
  }
  message.mutable_positions()->CopyFrom(message.rest());
  FakeMeshServer teller({message});
  Observer observer(To(teller.address), {});
  observer.Need(User::kTable, kMeshes);
  ASSERT_TRUE(Eventually([&] { return observer.mesh_stats().meshes > 0; }));
  EXPECT_EQ(observer.mesh()->positions.size(), static_cast<std::size_t>(kNodes));
  EXPECT_EQ(teller.asked_rate, 120);
}

TEST_F(ObserverTest, MeshesThatCannotBeAreCountedReportedAndNeverHandedOn) {
  v1::MeshState headless;
  headless.mutable_sensed_at();
  for (int i = 0; i < 3; ++i) headless.add_positions(0);
  FakeMeshServer teller({headless, headless});
  Observer observer(To(teller.address), {});
  observer.Need(User::kTable, kMeshes);
  ASSERT_TRUE(Eventually([&] { return observer.mesh_stats().refused == 2; }));
  EXPECT_EQ(observer.mesh(), nullptr);
  EXPECT_THAT(observer.mesh_stats().trouble, HasSubstr("a mesh was rejected: rest is absent"));
}

TEST_F(ObserverTest, ImagesHaveOverlaysAndAreMadeOnlyWhileTheyAreRead) {
  slave_.TakeSample();
  EXPECT_EQ(slave_.images_taken(), 0);
  Observer observer(Line(), {});
  observer.Need(User::kPage, kImages);
  ASSERT_TRUE(SensingUntil([&] { return observer.image() && observer.image()->number > 2; }));
  EXPECT_EQ(observer.image()->jpeg, "overlays 75");
  EXPECT_EQ(observer.image()->width, 640);
  EXPECT_EQ(observer.image_trouble(), "");
}

TEST_F(ObserverTest, TheSlaveReportsItsSceneAndStatus) {
  Observer observer(Line(), {.health = true});
  ASSERT_TRUE(SensingUntil([&] { return observer.health().scene && observer.health().status; }));
  EXPECT_EQ(observer.health().scene->material().young_modulus(),
            slave_.Describe().scene.object.material.young_modulus);
  EXPECT_NE(observer.health().status->phase(), v1::PHASE_UNSPECIFIED);
  EXPECT_EQ(observer.health().trouble, "");
}

// A page and a recording share each stream; the higher request decides.
TEST_F(ObserverTest, UsersShareOneStreamOfEachKind) {
  std::mutex mutex;
  std::set<std::string> received;
  Observer observer(Line(), {.health = true, .on_message = [&](const auto& message) {
                               const std::scoped_lock lock(mutex);
                               received.insert(message.GetDescriptor()->name());
                             }});
  observer.Need(User::kRecording, {.image_rate = 2, .mesh_rate = 2});
  observer.Need(User::kPage, {.image_rate = 120, .mesh_rate = 120});
  ASSERT_TRUE(SensingUntil([&] {
    const std::scoped_lock lock(mutex);
    return received.size() == 5 && observer.image() && observer.mesh();
  }));
  EXPECT_THAT(received, testing::UnorderedElementsAre("ImageState", "MeshState", "TraceUpdate",
                                                      "Status", "SceneDescription"));
  observer.Need(User::kPage, {});
  const std::uint64_t before = observer.mesh_stats().meshes;
  EXPECT_TRUE(SensingUntil([&] { return observer.mesh_stats().meshes > before; }))
      << "the recording still needs them";
}

}  // namespace
}  // namespace palpate
