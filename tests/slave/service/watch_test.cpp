// Observers: any number up to the seats, each with its own newest state.
#include <algorithm>
#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/service/observers/mesh_stream_encoder.h"
#include "slave/service/publisher.h"
#include "slave/service/teleoperation_service.h"
#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class WatchTest : public ServiceTest {
 protected:
  // Starts and cancels a WatchState. Returns the reason of a refusal.
  grpc::Status Watch() {
    CallContext context;
    const auto stream = stub->WatchState(&context, {});
    v1::SlaveState state;
    if (stream->Read(&state)) {
      context.TryCancel();
      stream->Finish();
      return grpc::Status::OK;
    }
    return stream->Finish();
  }
  const std::unique_ptr<v1::Teleoperation::Stub> stub = Connect();
};

// Two readers of the same states: the one that requested 20 per second at most gets fewer, by
// the states' own stamps. Tolerance: the rate is counted over a second between stamps, which are
// taken up to one period (5 ms) before the sending that is paced.
TEST_F(WatchTest, NoMoreStatesComeThanAskedFor) {
  CallContext context;
  v1::WatchStateRequest request;
  request.set_max_rate(20);
  const auto stream = stub->WatchState(&context, request);
  v1::SlaveState state;
  ASSERT_TRUE(stream->Read(&state));
  const auto seconds = [](const v1::SlaveState& s) {
    return static_cast<double>(s.sent_at().seconds()) + 1e-9 * s.sent_at().nanos();
  };
  const double start = seconds(state);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(stream->Read(&state));
  EXPECT_GE(seconds(state) - start, 20 / 20.0 - 0.01);
  context.TryCancel();
}

TEST_F(WatchTest, MeasurementsOfTheChecksAreSentOnRequest) {
  for (const bool asked : {false, true}) {
    CallContext context;
    v1::WatchStateRequest request;
    request.set_details(asked);
    const auto stream = stub->WatchState(&context, request);
    v1::SlaveState state;
    ASSERT_TRUE(stream->Read(&state));
    EXPECT_EQ(state.has_details(), asked);
    EXPECT_EQ(state.details().has_score(), asked);
    EXPECT_EQ(state.has_moment(), asked);
    EXPECT_EQ(state.moment().z(), asked ? 2e-3F : 0);
    EXPECT_EQ(state.moment_sigma(), asked ? 1e-4F : 0);
    EXPECT_EQ(state.details().score(), asked ? 0.75F : 0);
    EXPECT_EQ(state.details().camera_motion_px(), asked ? 1.5F : 0);
    EXPECT_FALSE(state.details().has_contour_px()) << "a check that was not made";
    context.TryCancel();
  }
}

// A reader stops reading for 600 states. The others continue. When it reads again, it gets the
// states in its receive window (limited by the HTTP/2 window, not by time) and then the newest.
// Law: a slow reader loses old values, does not delay others and does not increase the memory used.
TEST_F(WatchTest, AStalledReaderLosesOldStatesAndSlowsNobody) {
  const auto stalled_stub = ConnectWithSmallWindow();
  grpc::ClientContext stalled_context;
  stalled_context.set_deadline(std::chrono::system_clock::now() + 2 * kLiveness);
  const auto stalled = stalled_stub->WatchState(&stalled_context, {});
  v1::SlaveState first;
  ASSERT_TRUE(stalled->Read(&first));

  CallContext context;
  const auto diligent = stub->WatchState(&context, {});
  v1::SlaveState state;
  for (int i = 0; i < 600; ++i) {
    slave_.TakeSample();
    ASSERT_TRUE(diligent->Read(&state));
  }
  const std::uint64_t now = state.sequence();
  context.TryCancel();

  std::uint64_t old_states = 0;
  do {
    ASSERT_TRUE(stalled->Read(&state));
    ++old_states;
  } while (state.sequence() < now);
  EXPECT_GE(now - first.sequence(), 600U);
  EXPECT_LT(old_states, 300U) << "states were queued for a reader that did not read";
  stalled_context.TryCancel();
}

// Both streams have written until their windows were full, and wait there for readers who never
// read.
TEST_F(WatchTest, StalledReadersDoNotKeepTheServerFromStopping) {
  Operator ada(ConnectWithSmallWindow());
  ASSERT_TRUE(ada.Read().has_value());
  const auto stalled_stub = ConnectWithSmallWindow();
  CallContext stalled_context;
  const auto stalled = stalled_stub->WatchState(&stalled_context, {});
  std::uint64_t sent = 0;
  ASSERT_TRUE(Eventually([&] {
    const std::uint64_t before = sent;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    sent = GetStatus().states();
    return sent > 0 && sent == before;
  })) << "the windows never filled";
  server_->Stop();
  EXPECT_EQ(slave_.ends(), 1);
}

TEST_F(WatchTest, ObserversBeyondTheSeatsAreRefused) {
  struct Watcher {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<v1::SlaveState>> stream;
  };
  std::vector<std::unique_ptr<Watcher>> watchers;
  v1::SlaveState state;
  v1::WatchStateRequest slowly;
  slowly.set_max_rate(1);
  for (int i = 0; i < TeleoperationService::kSeats; ++i) {
    auto& watcher = *watchers.emplace_back(std::make_unique<Watcher>());
    SetDeadline(&watcher.context);
    watcher.stream = stub->WatchState(&watcher.context, slowly);
    ASSERT_TRUE(watcher.stream->Read(&state)) << i;
  }
  EXPECT_EQ(Watch().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(GetStatus().alarms(),
              testing::Contains(testing::HasSubstr("a stream of SlaveState of ipv4:127.0.0.1:")));
  Operator ada(Connect());  // has separate places, by its connection or its name
  ada.Hold(0, "Ada");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 1; }));
  CallContext own, named;
  named.AddMetadata("palpate-operator-bin", "Ada");
  EXPECT_TRUE(ada.stub().WatchState(&own, slowly)->Read(&state));
  EXPECT_TRUE(stub->WatchState(&named, slowly)->Read(&state));
  own.TryCancel();
  named.TryCancel();
  watchers.front()->context.TryCancel();
  EXPECT_TRUE(Eventually([&] { return Watch().ok(); })) << "the seat did not become free";
  for (auto& watcher : watchers) watcher->context.TryCancel();
}

// A client requests each quality in turn.
TEST_F(WatchTest, FewEncodedImagesAreKeptAndThoseOfTheNewestSampleAlone) {
  FakeSlave slave;
  Publisher publisher(slave);
  TeleoperationService service(slave, publisher, {});
  slave.TakeSample();
  service.Encoded({}, true, 50);  // no image yet
  std::vector<std::weak_ptr<const EncodedImage>> images;
  for (int quality = 10; quality <= 100; ++quality) {
    images.push_back(service.Encoded({}, true, quality));
  }
  const auto kept = [&] {
    return std::ranges::count_if(images, [](const auto& image) { return !image.expired(); });
  };
  EXPECT_EQ(kept(), TeleoperationService::kMaxEncoded);
  slave.TakeSample();
  const auto newest = service.Encoded(slave.Compose(Clock::now()).sensed_at, true, 50);
  ASSERT_TRUE(newest);
  EXPECT_EQ(kept(), 0);
}

TEST_F(WatchTest, AStoppingServerEndsEveryStreamAsUnavailable) {
  grpc::ClientContext state_context, mesh_context, video_context;
  for (auto* context : {&state_context, &mesh_context, &video_context}) SetDeadline(context);
  v1::WatchStateRequest slowly;
  slowly.set_max_rate(1);
  const auto states = stub->WatchState(&state_context, slowly);
  const auto meshes = stub->WatchMesh(&mesh_context, {});
  const auto videos = stub->WatchImages(&video_context, {});
  v1::SlaveState state;
  v1::MeshState mesh;
  v1::ImageState frame;
  ASSERT_TRUE(states->Read(&state));
  ASSERT_TRUE(meshes->Read(&mesh));
  slave_.TakeSample();
  ASSERT_TRUE(videos->Read(&frame));
  server_->Stop();
  const auto drain = [](auto* stream, auto* message) {
    while (stream->Read(message)) {
    }
    return stream->Finish().error_code();
  };
  EXPECT_EQ(drain(states.get(), &state), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(drain(meshes.get(), &mesh), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(drain(videos.get(), &frame), grpc::StatusCode::UNAVAILABLE);
}

// Reference: the force itself. The nodal forces, distributed by hand over two triangles by their
// areas, sum to it. Tolerance: single precision.
TEST(MeshStreamEncoderTest, TractionIsSentOnRequestAndAddsUpToTheForce) {
  BoundaryShape shape;
  shape.nodes_per_element = 3;
  shape.elements = {0, 1, 2, 0, 2, 3};
  shape.rest = {0, 0, 0, 0.02F, 0, 0, 0.02F, 0.01F, 0, 0, 0.01F, 0};
  shape.positions = shape.rest;
  shape.nodal_forces = {0, 0, -0.5F, 0, 0, -0.3F, 0, 0, -0.2F, 0, 0, 0};  // one newton
  v1::WatchMeshRequest request;
  v1::MeshState message;
  MeshStreamEncoder(request).Encode(shape, &message);
  EXPECT_EQ(message.traction_size(), 0);
  request.set_traction(true);
  MeshStreamEncoder encoder(request);
  EXPECT_TRUE(encoder.needs().nodal_forces);
  encoder.Encode(shape, &message);
  EXPECT_EQ(message.nodal_forces_size(), 0) << "not asked for";
  ASSERT_EQ(message.traction_size(), 4);
  const std::array<double, 4> areas{2e-4 / 3, 1e-4 / 3, 2e-4 / 3, 1e-4 / 3};
  double force = 0;
  for (int i = 0; i < 4; ++i) force += areas[static_cast<std::size_t>(i)] * message.traction(i);
  EXPECT_NEAR(force, 1, 1e-6);
  shape.nodal_forces.clear();  // a force is unknown
  encoder.Encode(shape, &message);
  EXPECT_EQ(message.traction_size(), 0);
}

TEST(MeshStreamEncoderTest, TheFieldIsComputedOnRequestAndItsTopologySentOnce) {
  BoundaryShape shape;
  shape.elements = {0, 1, 1, 2, 2, 0};
  shape.rest = shape.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  v1::WatchMeshRequest request;
  EXPECT_FALSE(MeshStreamEncoder(request).needs().field);
  request.set_field(true);
  MeshStreamEncoder encoder(request);
  EXPECT_TRUE(encoder.needs().field);
  shape.field.emplace();
  shape.field->triangles = {0, 1, 2};
  shape.field->rest = shape.rest;
  shape.field->displacement = {0, 0.5F, 0, 0, 0, 0, 0, 0, 0};
  shape.field->image = {10, 20, 30, 20, 10, 0};
  v1::MeshState message;
  for (const bool is_first : {true, false}) {
    encoder.Encode(shape, &message);
    EXPECT_EQ(message.field().triangles_size(), is_first ? 3 : 0);
    EXPECT_EQ(message.field().rest_size(), is_first ? 9 : 0);
    ASSERT_EQ(message.field().displacement_size(), 9);
    EXPECT_EQ(message.field().displacement(1), 0.5F);
    EXPECT_EQ(message.field().image_size(), 6);
  }
  shape.field.reset();  // no model
  encoder.Encode(shape, &message);
  EXPECT_FALSE(message.has_field());
}

}  // namespace
}  // namespace palpate
