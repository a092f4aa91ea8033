// Drivers feed tactile samples; the errors they receive for bad ones.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/service/messages.h"
#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

using testing::HasSubstr;

// Sample `i` of `finger`, at 100 Hz: electrode k reads 3000 + k.
v1::TactileSample Sample(const std::string& finger, int i) {
  v1::TactileSample sample;
  sample.set_sequence(static_cast<std::uint64_t>(i + 1));
  sample.mutable_sensed_at()->set_seconds(1'000'000 + i / 100);
  sample.mutable_sensed_at()->set_nanos(i % 100 * 10'000'000);
  sample.set_finger(finger);
  for (int k = 0; k < kElectrodeCount; ++k) sample.add_electrodes(static_cast<float>(3000 + k));
  sample.add_pressure(2000);
  sample.add_pressure(1800);
  return sample;
}

class FeedTactileTest : public ServiceTest {
 protected:
  FeedTactileTest() { slave_.TakeTactile({"rf", "th"}); }

  // The client side of a driver's stream.
  class Feed {
   public:
    explicit Feed(std::unique_ptr<v1::Teleoperation::Stub> stub) : stub_(std::move(stub)) {
      SetDeadline(&context_);
      writer_ = stub_->FeedTactile(&context_, &reply_);
    }
    bool Send(const v1::TactileSample& sample) { return writer_->Write(sample); }
    grpc::Status Finish() {
      writer_->WritesDone();
      return writer_->Finish();
    }
    // Waits for the slave to end the stream, without half-closing it.
    grpc::Status WaitForEnd() { return writer_->Finish(); }
    void Vanish() { context_.TryCancel(); }
    std::uint64_t samples() const { return reply_.samples(); }

   private:
    std::unique_ptr<v1::Teleoperation::Stub> stub_;
    grpc::ClientContext context_;
    v1::FeedTactileReply reply_;
    std::unique_ptr<grpc::ClientWriter<v1::TactileSample>> writer_;
  };

  std::optional<TactileFrame> NextFrame() { return slave_.tactile_inbox()->Next({}); }
};

TEST_F(FeedTactileTest, SamplesComeOutAsFramesAndAreCounted) {
  Feed feed(Connect());
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(feed.Send(Sample("th", i)));
  ASSERT_TRUE(feed.Finish().ok());
  EXPECT_EQ(feed.samples(), 20U);
  std::optional<TactileFrame> frame;
  for (int i = 0; i < 20; ++i) frame = NextFrame();
  EXPECT_EQ(frame->sequence, 20U);
  EXPECT_FALSE(frame->fingers[0].present);
  EXPECT_TRUE(frame->fingers[1].present);
  EXPECT_EQ(frame->fingers[1].channels[18], 3018);
  EXPECT_EQ(frame->fingers[1].pdc, 2000);
  EXPECT_EQ(frame->fingers[1].pac, 1800);
  EXPECT_LE(frame->sensed_at, Clock::now());
}

TEST_F(FeedTactileTest, OneStreamMayBringSeveralFingersAndSeveralStreamsOneSlave) {
  Feed both(Connect());
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(both.Send(Sample("rf", i)));
    ASSERT_TRUE(both.Send(Sample("th", i)));
  }
  ASSERT_TRUE(both.Finish().ok());
  EXPECT_EQ(both.samples(), 20U);
  Feed rf(Connect());
  Feed th(Connect());
  ASSERT_TRUE(rf.Send(Sample("rf", 0)));  // a new driver: clock and sequence start again
  ASSERT_TRUE(th.Send(Sample("th", 0)));
  EXPECT_TRUE(rf.Finish().ok());
  EXPECT_TRUE(th.Finish().ok());
}

struct BadSample {
  const char* name;
  std::function<void(v1::TactileSample*)> apply;
  const char* message;
};

class BadSampleTest : public FeedTactileTest, public testing::WithParamInterface<BadSample> {};

// The samples before the bad one are accepted; the stream is over.
TEST_P(BadSampleTest, EndsTheStreamWithASentence) {
  Feed feed(Connect());
  ASSERT_TRUE(feed.Send(Sample("rf", 0)));
  v1::TactileSample bad = Sample("rf", 1);
  GetParam().apply(&bad);
  ASSERT_TRUE(feed.Send(bad));
  const grpc::Status status = feed.WaitForEnd();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr(GetParam().message));
  EXPECT_THAT(status.error_message(), HasSubstr("expected"));
  EXPECT_TRUE(NextFrame()->fingers[0].present);
}

void Pose(v1::TactileSample* sample, double x, double qw, double qx) {
  sample->mutable_p_s_finger()->set_x(x);
  for (const double q : {qw, qx, 0.0, 0.0}) sample->add_orientation(q);
}

INSTANTIATE_TEST_SUITE_P(
    Samples, BadSampleTest,
    testing::Values(BadSample{"Eighteen", [](auto* s) { s->mutable_electrodes()->RemoveLast(); },
                              "finger rf has 18 electrodes: expected 19, E1 to E19"},
                    BadSample{"AnotherUnit", [](auto* s) { s->set_unit("kPa"); },
                              "finger rf unit = kPa: expected counts"},
                    BadSample{"NoSuchFinger", [](auto* s) { s->set_finger("mf"); },
                              "finger mf is not a finger of this scene: expected rf, th"},
                    BadSample{"NoStamp", [](auto* s) { s->clear_sensed_at(); },
                              "sensed_at is absent"},
                    BadSample{"HalfAPose", [](auto* s) { s->mutable_p_s_finger()->set_x(1); },
                              "orientation is absent: expected an orientation"},
                    BadSample{"NoUnitQuaternion", [](auto* s) { Pose(s, 0, 1, 1); },
                              "orientation: expected a unit quaternion"},
                    BadSample{"PlaceOfNaN", [](auto* s) { Pose(s, std::nan(""), 1, 0); },
                              "p_S_finger.x = nan"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST_F(FeedTactileTest, APoseTravelsWithItsSample) {
  Feed feed(Connect());
  v1::TactileSample sample = Sample("rf", 0);
  Pose(&sample, 0.5, std::sqrt(0.5), std::sqrt(0.5));
  ASSERT_TRUE(feed.Send(sample));
  const auto frame = NextFrame();
  ASSERT_TRUE(frame->fingers[0].X_SF.has_value());
  const Eigen::Vector3d p_S = *frame->fingers[0].X_SF * Eigen::Vector3d(0, 1, 0);
  EXPECT_LT((p_S - Eigen::Vector3d(0.5, 0, 1)).norm(), 1e-12);
}

TEST_F(FeedTactileTest, ADriverThatVanishesMakesRoomForTheNext) {
  {
    Feed feed(Connect());
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(feed.Send(Sample("rf", i)));
    for (int i = 0; i < 5; ++i) NextFrame();
    feed.Vanish();
  }
  EXPECT_TRUE(Eventually([&] {  // as soon as the slave knows that the stream has ended
    Feed feed(Connect());
    feed.Send(Sample("rf", 0));
    return feed.Finish().ok() && feed.samples() == 1;
  }));
  EXPECT_TRUE(NextFrame()->after_gap);
}

}  // namespace
}  // namespace palpate
