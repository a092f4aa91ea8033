// Drivers of cameras and arms: their messages, and the errors they receive.
#include <chrono>
#include <limits>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

using testing::HasSubstr;

v1::ImageSample Image(int i) {
  v1::ImageSample sample;
  sample.set_sequence(static_cast<std::uint64_t>(i + 1));
  sample.mutable_sensed_at()->set_seconds(1'000'000 + i);
  auto* image = sample.mutable_image();
  image->set_encoding(v1::Image::ENCODING_GREY8);
  image->set_width(64);
  image->set_height(48);
  image->set_data(std::string(64 * 48, static_cast<char>(i)));
  return sample;
}

// Feeds `samples` on a separate stream.
grpc::Status FeedAll(v1::Teleoperation::Stub& stub, const std::vector<v1::ImageSample>& samples,
                     v1::FeedImagesReply* reply) {
  CallContext context;
  const auto writer = stub.FeedImages(&context, reply);
  for (const auto& sample : samples) writer->Write(sample);
  writer->WritesDone();
  return writer->Finish();
}

class DevicesTest : public ServiceTest {
 protected:
  v1::FeedImagesReply reply_;
};

class ImagesTest : public DevicesTest {
 protected:
  ImagesTest() {
    slave_.TakeImages();
    server_ = std::make_unique<Server>(slave_, "127.0.0.1:0", false);
  }
};

TEST_F(ImagesTest, AreTakenAndCounted) {
  EXPECT_TRUE(FeedAll(*Connect(), {Image(0), Image(1), Image(2)}, &reply_).ok());
  EXPECT_EQ(reply_.samples(), 3U);
  const auto source = slave_.image_inbox()->OpenFrames({});
  EXPECT_EQ(source->Next({})->image.at<unsigned char>(5, 5), 2);
}

TEST_F(ImagesTest, OfAnotherSizeEndTheStreamInWords) {
  v1::ImageSample wrong = Image(1);
  wrong.mutable_image()->set_width(32);
  EXPECT_THAT(FeedAll(*Connect(), {Image(0), wrong}, &reply_),
              EndedWith(grpc::StatusCode::INVALID_ARGUMENT,
                        HasSubstr("sample 2: data of 3072 bytes: expected 1536")));
}

// The client side of an arm driver's stream.
class Driver {
 public:
  explicit Driver(std::unique_ptr<v1::Teleoperation::Stub> stub) : stub_(std::move(stub)) {
    SetDeadline(&context_);
    stream_ = stub_->DriveTool(&context_);
  }
  v1::ArmReport Report(double x) {
    v1::ArmReport report;
    report.set_sequence(++sequence_);
    report.mutable_measured_at()->set_seconds(1'000'000);
    report.mutable_measured_at()->set_nanos(static_cast<int>(sequence_) * 1000);
    report.mutable_p_s_tip()->set_x(x);
    report.add_orientation(1);
    for (int i = 0; i < 3; ++i) report.add_orientation(0);
    report.set_driver_name("a driver");
    return report;
  }
  bool Send(const v1::ArmReport& report) { return stream_->Write(report); }
  std::optional<v1::ArmTarget> Read() {
    v1::ArmTarget target;
    return stream_->Read(&target) ? std::optional(target) : std::nullopt;
  }
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
  std::unique_ptr<grpc::ClientReaderWriter<v1::ArmReport, v1::ArmTarget>> stream_;
  std::uint64_t sequence_ = 0;
};

class ArmTest : public DevicesTest {
 protected:
  ArmTest() { slave_.TakeArm({.silence = 60, .max_speed = 1e3}); }
};

TEST_F(ArmTest, TargetsComeAtOnceAndFollowWhatTheSlaveCommands) {
  Driver driver(Connect());
  ASSERT_TRUE(driver.Send(driver.Report(0.25)));
  auto target = driver.Read();
  ASSERT_TRUE(target);
  EXPECT_EQ(target->motion(), v1::ArmTarget::MOTION_HOLD);
  EXPECT_EQ(target->p_s_tip().x(), 0.25);
  EXPECT_EQ(target->orientation_size(), 4);
  ASSERT_TRUE(slave_.arm().Command({0.5, 0, 0}));
  while (target && target->p_s_tip().x() < 0.5 - 1e-6) target = driver.Read();
  ASSERT_TRUE(target);
  EXPECT_EQ(target->motion(), v1::ArmTarget::MOTION_FOLLOW);
  EXPECT_EQ(target->echo().seconds(), 1'000'000);
  EXPECT_TRUE(driver.Leave().ok());
  EXPECT_TRUE(slave_.arm().is_faulty());
}

// The connection delivers nothing for 1.3 s while the driver sends 3850 reports per second.
TEST_F(ArmTest, ReportsDelayedByTheNetworkAreAccepted) {
  Driver driver(Connect());
  ASSERT_TRUE(driver.Send(driver.Report(0)));
  ASSERT_TRUE(driver.Read());
  std::this_thread::sleep_for(std::chrono::milliseconds(1300));
  for (int i = 0; i < 5000; ++i) ASSERT_TRUE(driver.Send(driver.Report(0))) << i;
  EXPECT_TRUE(driver.Leave().ok());
}

TEST_F(ArmTest, OneDriverAtATime) {
  Driver first(Connect());
  ASSERT_TRUE(first.Send(first.Report(0)));
  ASSERT_TRUE(first.Read());
  Driver second(Connect());
  second.Send(second.Report(0));
  EXPECT_THAT(second.Finish(), EndedWith(grpc::StatusCode::FAILED_PRECONDITION,
                                         HasSubstr("the manipulator is driven by a driver")));
  EXPECT_FALSE(slave_.arm().is_faulty()) << "the first drives on";
}

struct BadReport {
  const char* name;
  void (*apply)(v1::ArmReport*);
  const char* words;
};

class BadReportTest : public ArmTest, public testing::WithParamInterface<BadReport> {};

TEST_P(BadReportTest, EndsTheStreamInWordsAndIsAFault) {
  Driver driver(Connect());
  ASSERT_TRUE(driver.Send(driver.Report(0)));
  ASSERT_TRUE(driver.Read());
  v1::ArmReport bad = driver.Report(0);
  GetParam().apply(&bad);
  driver.Send(bad);
  EXPECT_THAT(driver.Finish(),
              EndedWith(grpc::StatusCode::INVALID_ARGUMENT, HasSubstr(GetParam().words)));
  EXPECT_TRUE(slave_.arm().is_faulty());
}

INSTANTIATE_TEST_SUITE_P(All, BadReportTest,
                         testing::Values(BadReport{"NotANumber",
                                                   [](v1::ArmReport* r) {
                                                     r->mutable_p_s_tip()->set_x(
                                                         std::numeric_limits<double>::quiet_NaN());
                                                   },
                                                   "p_S_tip.x = nan: expected"},
                                         BadReport{"HalfAQuaternion",
                                                   [](v1::ArmReport* r) { r->add_orientation(0); },
                                                   "expected a unit quaternion"}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace palpate
