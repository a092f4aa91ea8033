// What the station watches beside the force, against a real server with a fake slave behind it.
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/link/slave_link.h"
#include "master/link/slave_status_poller.h"
#include "master/link/video_watch.h"
#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class ObserverWatchTest : public testing::Test {
 protected:
  [[nodiscard]] SlaveLink::Options Line() const {
    SlaveLink::Options options;
    options.target = server_->address();
    return options;
  }
  // Something is sensed until `condition`.
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

TEST_F(ObserverWatchTest, PicturesComeWithOverlaysAndNobodyMakesThemForNobody) {
  slave_.TakeSample();
  EXPECT_EQ(slave_.pictures_taken(), 0);
  const VideoWatch watch(Line(), {.rate = 120, .quality = 75});
  ASSERT_TRUE(SensingUntil([&] { return watch.newest() && watch.newest()->number > 2; }));
  EXPECT_EQ(watch.newest()->jpeg, "overlays 75");
  EXPECT_EQ(watch.newest()->width, 640);
  EXPECT_EQ(watch.trouble(), "");
}

TEST_F(ObserverWatchTest, ASlaveWithoutACameraIsSaidInItsWords) {
  slave_.set_has_camera(false);
  const VideoWatch watch(Line(), {});
  ASSERT_TRUE(SensingUntil([&] { return !watch.trouble().empty(); }));
  EXPECT_THAT(watch.trouble(), HasSubstr("camera"));
  EXPECT_FALSE(watch.newest());
}

TEST_F(ObserverWatchTest, TheSlaveTellsOfItselfAndOfWhatHappens) {
  SlaveStatusPoller poller(Line());
  ASSERT_TRUE(
      SensingUntil([&] { return poller.felt().state.sequence > 0 && poller.words().version > 0; }));
  EXPECT_THAT(poller.words().scene, HasSubstr("\"young_modulus\""));
  EXPECT_THAT(poller.words().status, HasSubstr("\"phase\""));
  EXPECT_EQ(poller.words().trouble, "");
  Events events;
  slave_.Happen(Event::kPuncture);
  ASSERT_TRUE(SensingUntil([&] {
    events.Add(poller.TakeEvents());
    return events.Has(Event::kPuncture);
  }));
  EXPECT_FALSE(poller.TakeEvents().Has(Event::kPuncture)) << "once is enough";
}

TEST_F(ObserverWatchTest, ASamplesTraceIsFoundByWhenItWasTaken) {
  SlaveStatusPoller poller(Line());
  std::optional<SampleTrace> trace;
  Time sensed_at{};
  ASSERT_TRUE(SensingUntil([&] {
    sensed_at = poller.felt().state.sensed_at;
    trace = poller.TraceOf(sensed_at);
    return trace.has_value();
  }));
  EXPECT_GT(trace->sample, 0U);
  EXPECT_EQ(trace->sensed_at, sensed_at);
  EXPECT_FALSE(poller.TraceOf(sensed_at + Clock::duration(1)));
}

TEST_F(ObserverWatchTest, ASlaveThatIsGoneIsSaidAndFoundAgain) {
  const SlaveStatusPoller poller(Line());
  ASSERT_TRUE(SensingUntil([&] { return !poller.words().scene.empty(); }));
  const std::string address = server_->address();
  server_.reset();
  ASSERT_TRUE(SensingUntil([&] { return !poller.words().trouble.empty(); }));
  server_ = std::make_unique<Server>(slave_, address, false);
  EXPECT_TRUE(SensingUntil([&] { return poller.words().trouble.empty(); }));
}

TEST_F(ObserverWatchTest, BeyondThisMachineNeedsAWord) {
  SlaveLink::Options far;
  far.target = "192.0.2.1:50051";
  EXPECT_THROW(SlaveStatusPoller{far}, std::invalid_argument);
  EXPECT_THROW((VideoWatch{far, {}}), std::invalid_argument);
}

// Reference: what the fake accepts, `bem2d` alone, and its words for the rest.
TEST_F(ObserverWatchTest, MappingAndModelAreSetOrRefusedWithTheReason) {
  SlaveLink link(Line());
  EXPECT_EQ(link.SetMapping({.position_scale = 0.5}), "");
  EXPECT_EQ(slave_.parameters().position_scale, 0.5);
  EXPECT_FALSE(slave_.parameters().force_scale);
  EXPECT_EQ(link.SetModel("bem2d"), "");
  EXPECT_NE(link.SetModel("clay"), "");
  EXPECT_NE(link.SetMapping({.force_scale = -1}), "");
}

}  // namespace
}  // namespace palpate
