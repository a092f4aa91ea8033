// Images that drivers send: which are accepted, which are refused, and the messages.
#include "slave/capture/image_inbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/pace_limit.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using Encoding = PushedImage::Encoding;

constexpr ImageInbox::SenderId kDriver = 1, kOther = 2;
constexpr int kPushedWidth = 64, kPushedHeight = 48;

Scene Mono() {
  Scene scene;
  scene.sense.Set(CameraOptions{.camera = Camera{.source = Camera::Source::kStream,
                                                 .rate = 30,
                                                 .size = {kPushedWidth, kPushedHeight}}});
  return scene;
}

Scene PushedPair() {
  Scene scene;
  StereoCameras pair;
  pair.source = StereoCameras::Source::kStream;
  pair.size = {kPushedWidth, kPushedHeight};
  scene.sense.Set(PointsOptions{.cameras = pair});
  return scene;
}

Scene Depth() {
  Scene scene;
  scene.sense.Set(PointsOptions{.cameras = DepthImages{.source = DepthImages::Source::kStream}});
  return scene;
}

cv::Mat Ramp(int type, int width = kPushedWidth) {
  cv::Mat image(kPushedHeight, width, type);
  for (int i = 0; i < static_cast<int>(image.total() * image.elemSize()); ++i) {
    image.data[i] = static_cast<unsigned char>(i % 251);
  }
  return image;
}

std::string Raw(const cv::Mat& image) {
  return {reinterpret_cast<const char*>(image.data), image.total() * image.elemSize()};
}

PushedImage Push(Encoding encoding, const std::string& data, int width = 0, int height = 0) {
  return {encoding, &data, static_cast<unsigned>(width), static_cast<unsigned>(height)};
}

class ImageInboxTest : public testing::Test {
 protected:
  // Returns a sample 1/30 s after the last. The sender's clock is 50 s behind the slave's.
  PushedSample Sample(const PushedImage& image) {
    now_ += Seconds(1.0 / 30);
    PushedSample sample;
    sample.sequence = ++sequence_;
    sample.sensed_at = now_ - Seconds(50);
    sample.image = image;
    return sample;
  }
  std::string Feed(ImageInbox& inbox, const PushedSample& sample,
                   ImageInbox::SenderId sender = kDriver) {
    const auto refusal = inbox.Feed(sample, now_ + Seconds(latency_), sender);
    return refusal ? refusal->why : "";
  }

  const std::string grey_ = Raw(Ramp(CV_8UC1)), png_ = EncodePng(Ramp(CV_8UC3)),
                    jpeg_ = EncodeJpeg(Ramp(CV_8UC1), 95), wide_ = EncodePng(Ramp(CV_8UC1, 80));
  Time now_ = Time{} + Seconds(1000);
  double latency_ = 0.002;  // [s]
  std::uint64_t sequence_ = 0;
};

TEST_F(ImageInboxTest, ImagesComeOutAsTheyWerePushedOnOurClock) {
  ImageInbox inbox(Mono());
  const auto source = inbox.OpenFrames({});
  EXPECT_EQ(Feed(inbox, Sample(Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight))), "");
  const auto frame = source->Next({});
  ASSERT_TRUE(frame);
  EXPECT_EQ(cv::norm(frame->image, Ramp(CV_8UC1), cv::NORM_INF), 0);
  EXPECT_NEAR(SecondsBetween(now_, frame->sensed_at), latency_, 1e-6);
  EXPECT_EQ(inbox.taken_at(), frame->sensed_at);
  latency_ = 0.020;  // a slow one: it was taken no later for that
  EXPECT_EQ(Feed(inbox, Sample(Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight))), "");
  EXPECT_NEAR(SecondsBetween(now_, source->Next({})->sensed_at), 0.002, 1e-6);
}

// Without a known delay the fastest image is assumed to have none.
TEST_F(ImageInboxTest, TheDelayReportedByTheDriverIsSubtracted) {
  ImageInbox inbox(Mono());
  PushedSample sample = Sample(Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight));
  sample.delay = 0.02;
  EXPECT_EQ(Feed(inbox, sample), "");
  ASSERT_TRUE(inbox.Wait({}));
  const auto frame = inbox.OpenFrames({})->Next({});
  EXPECT_NEAR(SecondsBetween(frame->sensed_at, now_ + Seconds(latency_)), 0.02, 1e-6);
}

TEST_F(ImageInboxTest, PairsAreGreyAndStateTheirSkew) {
  ImageInbox inbox(PushedPair());
  const auto source = inbox.OpenPairs();
  PushedSample sample = Sample(Push(Encoding::kPng, png_));
  sample.right = Push(Encoding::kJpeg, jpeg_);
  sample.right_sensed_at = sample.sensed_at + Seconds(0.003);
  EXPECT_EQ(Feed(inbox, sample), "");
  const auto pair = source->Next({});
  EXPECT_EQ(pair->left.type(), CV_8UC1);
  EXPECT_EQ(pair->right.size(), cv::Size(kPushedWidth, kPushedHeight));
  EXPECT_NEAR(inbox.health().skew, 0.003, 1e-6);
  EXPECT_NEAR(pair->skew, 0.003, 1e-6);
  // As far as the slave can know, the right image arrived when it was taken.
  EXPECT_NEAR(SecondsBetween(pair->sensed_at, now_ + Seconds(latency_)), 0.0015, 1e-6);
}

TEST_F(ImageInboxTest, PairsTakenTooFarApartAreDroppedAndCounted) {
  ImageInbox inbox(PushedPair());
  for (const double skew : {0.0, 0.004, 0.006, -0.006}) {
    PushedSample sample = Sample(Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight));
    sample.right = sample.image;
    sample.right_sensed_at = sample.sensed_at + Seconds(skew);
    EXPECT_EQ(Feed(inbox, sample), "") << skew;
  }
  EXPECT_EQ(inbox.health().taken, 4U);
  EXPECT_EQ(inbox.health().dropped, 2U);
  EXPECT_THAT(inbox.health().trouble, HasSubstr("6 ms apart and are dropped: sync is 5 ms"));
  PushedSample together = Sample(Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight));
  together.right = together.image;
  EXPECT_EQ(Feed(inbox, together), "");
  EXPECT_EQ(inbox.health().trouble, "");
}

TEST_F(ImageInboxTest, WhatIsNotTheScenesIsRefusedInWords) {
  const auto refused = [&](const Scene& scene, const PushedImage& image) {
    ImageInbox inbox(scene);
    return Feed(inbox, Sample(image));
  };
  const std::string half = grey_.substr(0, 100), cut = png_.substr(0, png_.size() / 2);
  EXPECT_THAT(refused(Mono(), Push(Encoding::kGrey8, half, kPushedWidth, kPushedHeight)),
              HasSubstr("data of 100 bytes: expected 3072 for 64 x 48 px of GREY8"));
  EXPECT_THAT(refused(Mono(), Push(Encoding::kPng, wide_)),
              HasSubstr("80 x 48 px: expected the scene's 64 x 48 px"));
  EXPECT_THAT(refused(Mono(), Push(Encoding::kPng, cut)), HasSubstr("expected a complete PNG"));
  EXPECT_THAT(refused(Mono(), Push(Encoding::kJpeg, png_)), HasSubstr("not a JPEG"));
  EXPECT_THAT(refused(Mono(), Push(Encoding::kGrey8, grey_, 2'000'000, 2'000'000)),
              HasSubstr("expected at least one and at most 100000000 pixels"));
  EXPECT_THAT(refused(PushedPair(), Push(Encoding::kPng, png_)), HasSubstr("expected a pair"));
  EXPECT_THAT(refused(Depth(), Push(Encoding::kPng, png_)),
              HasSubstr("for depth, expected one channel of 16 bit"));
  ImageInbox inbox(Mono());
  PushedSample two = Sample(Push(Encoding::kPng, png_));
  two.right = two.image;
  EXPECT_THAT(Feed(inbox, two), HasSubstr("expected one image"));
}

TEST_F(ImageInboxTest, OneThatIsUnlikeTheFirstIsRefused) {
  ImageInbox inbox(Mono());
  EXPECT_EQ(Feed(inbox, Sample(Push(Encoding::kPng, png_))), "");
  EXPECT_THAT(Feed(inbox, Sample(Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight))),
              HasSubstr("1 channel of 8 bit: expected the format of the first image"));
}

TEST_F(ImageInboxTest, OrderAndPaceAreKept) {
  ImageInbox inbox(Mono());
  const PushedSample first = Sample(Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight));
  EXPECT_EQ(Feed(inbox, first), "");
  EXPECT_THAT(Feed(inbox, first), HasSubstr("expected a time that increases"));
  PushedSample old = Sample(first.image);
  old.sequence = 1;
  EXPECT_THAT(Feed(inbox, old), HasSubstr("sequence = 1: expected one above the last"));
  std::string flood;
  for (int i = 0; i < 200 && flood.empty(); ++i) {
    PushedSample sample = Sample(first.image);
    now_ -= Seconds(1.0 / 31);
    flood = Feed(inbox, sample);
  }
  EXPECT_THAT(flood, HasSubstr("more than 120 samples within a second"));
}

// Reference: arithmetic. 100 images per second are allowed, and after a silence of 5 s once as many
// as fit into it.
TEST(PaceLimitTest, ABurstAfterASilenceIsAllowedAFloodIsNot) {
  const auto allowed = [](PaceLimit& pace, Time now, double apart) {
    int count = 0;
    for (; count < 10000 && pace.Allows(now); ++count) now += Seconds(apart);
    return count;
  };
  const Time start{std::chrono::hours(1)};
  for (const double apart : {0.0, 0.005}) {  // at once, and twice as many as are allowed
    PaceLimit pace(100);
    EXPECT_NEAR(allowed(pace, start, apart), apart > 0 ? 200 : 100, 2);
  }
  PaceLimit pace(100);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(pace.Allows(start + Seconds(0.01 * i)));
  EXPECT_NEAR(allowed(pace, start + Seconds(15), 0), 500, 2);
  EXPECT_EQ(allowed(pace, start + Seconds(15), 0), 0);
  EXPECT_NEAR(allowed(pace, start + Seconds(1e6), 0), 100 * PaceLimit::kMaxStall, 1);
}

TEST_F(ImageInboxTest, OneSenderAtATimeAndTheNextStartsAgain) {
  ImageInbox inbox(Mono());
  const PushedImage grey = Push(Encoding::kGrey8, grey_, kPushedWidth, kPushedHeight);
  EXPECT_EQ(Feed(inbox, Sample(grey)), "");
  EXPECT_THAT(Feed(inbox, Sample(grey), kOther), HasSubstr("is already fed"));
  inbox.Leave(kDriver);
  PushedSample anew = Sample(grey);
  anew.sequence = 1;
  anew.sensed_at -= Seconds(1e6);
  EXPECT_EQ(Feed(inbox, anew, kOther), "");
}

}  // namespace
}  // namespace palpate
