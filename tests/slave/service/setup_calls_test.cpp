// The calls of the set-up: who may make them, and when.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/wire/errors.h"
#include "slave/live/scene_setup.h"
#include "tests/slave/service/service_fixture.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class RecordedSetup final : public SceneSetup {
 public:
  ProposalReport Check(const SceneProposal& proposal, Progress* /*progress*/) override {
    ++calls;
    ProposalReport report;
    if (proposal.files.empty()) {
      report.mistakes = {{.key = "tool.width",
                          .value = "0 mm",
                          .message = "not accepted",
                          .expected = "a length > 0",
                          .line = 7}};
    }
    return report;
  }
  std::unique_ptr<PreparedScene> Prepare(const SceneProposal& /*proposal*/,
                                         Progress* progress) override {
    ++calls;
    if (while_prepared) while_prepared(progress);
    return std::make_unique<Prepared>(this);
  }
  FoundOutline FindOutline(const cv::Mat& /*image*/, CurveView /*near*/) override {
    ++calls;
    return {};
  }
  FoundBoard FindBoard(const BoardImages& /*board*/, Progress* /*progress*/) override {
    ++calls;
    return {};
  }
  cv::Mat StartImage(const std::stop_token& /*stop*/) override {
    ++calls;
    return {};
  }

  std::function<void(Progress*)> while_prepared;
  std::function<void()> save;
  std::atomic<int> calls = 0, used = 0;

 private:
  class Prepared final : public PreparedScene {
   public:
    explicit Prepared(RecordedSetup* setup) : setup_(setup) {}
    [[nodiscard]] SlaveDescription Describe() const override { return {}; }
    void Use() override {
      if (setup_->save) setup_->save();
      ++setup_->used;
    }

   private:
    RecordedSetup* setup_;
  };
};

class SetupCallsTest : public ServiceTest {
 protected:
  SetupCallsTest() {
    slave_.TakeScenes(&setup_);
    server_ = std::make_unique<Server>(slave_, "127.0.0.1:0", false);
  }
  grpc::Status Propose(const v1::SceneProposal& proposal, v1::ProposeSceneReply* reply) const {
    CallContext context;
    return Connect()->ProposeScene(&context, proposal, reply);
  }
  grpc::Status Use() const {
    CallContext context;
    v1::SceneDescription reply;
    return Connect()->UseScene(&context, {}, &reply);
  }

  RecordedSetup setup_;
};

TEST_F(SetupCallsTest, AMistakeArrivesWithKeyValueLineAndWhatIsExpected) {
  v1::ProposeSceneReply reply;
  ASSERT_TRUE(Propose({}, &reply).ok());
  ASSERT_EQ(reply.errors_size(), 1);
  const v1::SceneError& error = reply.errors(0);
  EXPECT_EQ(error.key(), "tool.width");
  EXPECT_EQ(error.value(), "0 mm");
  EXPECT_EQ(error.line(), 7U);
  EXPECT_EQ(error.expected(), "a length > 0");
  EXPECT_FALSE(reply.has_scene());
}

TEST_F(SetupCallsTest, FilesOfMegabytesArrive) {
  v1::SceneProposal proposal;
  (*proposal.mutable_files())["tip.png"] = std::string(8'000'000, 'x');
  v1::ProposeSceneReply reply;
  const grpc::Status status = Propose(proposal, &reply);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(reply.errors_size(), 0);
}

TEST_F(SetupCallsTest, NoSetUpWhileAnOperatorWorks) {
  Operator ada(Connect());
  ASSERT_TRUE(ada.Hold(0, "ada"));
  ASSERT_TRUE(ada.Read());
  v1::ProposeSceneReply reply;
  for (const grpc::Status& status : {Use(), Propose({}, &reply)}) {
    EXPECT_THAT(status, EndedWith(grpc::StatusCode::FAILED_PRECONDITION, HasSubstr("ada")));
    EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_LEASE_HELD);
  }
  EXPECT_EQ(setup_.calls, 0);
  EXPECT_TRUE(ada.Leave().ok());
  EXPECT_TRUE(Use().ok());
  EXPECT_EQ(setup_.used, 1);
}

TEST_F(SetupCallsTest, AnOperatorWhoComesWhileASceneIsBuiltKeepsTheOldOne) {
  Operator ada(Connect());
  setup_.while_prepared = [&](Progress* /*progress*/) {
    ASSERT_TRUE(ada.Hold(0, "ada"));
    ASSERT_TRUE(ada.Read());
  };
  EXPECT_EQ(ReasonOf(Use()), v1::ERROR_REASON_LEASE_HELD);
  EXPECT_EQ(setup_.used, 0);
}

// After a scene is used, the slave ends and starts again.
TEST_F(SetupCallsTest, NobodyOperatesOnceASceneIsTakenIntoUse) {
  v1::ProposeSceneReply reply;
  EXPECT_TRUE(Use().ok());
  EXPECT_EQ(ReasonOf(Operator(Connect()).Finish()), v1::ERROR_REASON_NEW_SCENE);
  EXPECT_EQ(ReasonOf(Use()), v1::ERROR_REASON_NEW_SCENE);
  EXPECT_EQ(ReasonOf(Propose({}, &reply)), v1::ERROR_REASON_NEW_SCENE);
  EXPECT_EQ(setup_.used, 1);
  EXPECT_EQ(slave_.begins(), 0);
}

TEST_F(SetupCallsTest, ASceneThatCannotBeSavedChangesNothing) {
  setup_.save = [] { throw std::runtime_error("scene.yaml: cannot be written"); };
  EXPECT_EQ(ReasonOf(Use()), v1::ERROR_REASON_INTERNAL);
  Operator ada(Connect());
  EXPECT_TRUE(ada.Hold(0, "ada"));
  EXPECT_TRUE(ada.Read());
}

TEST_F(SetupCallsTest, TheWorkOfACancelledCallIsStopped) {
  std::atomic<bool> is_stopped = false;
  CallContext context;
  setup_.while_prepared = [&](Progress* progress) {
    if (is_stopped) return;
    context.TryCancel();
    is_stopped = Eventually([&] { return progress->stop().stop_requested(); });
    throw Interrupted();
  };
  v1::SceneDescription reply;
  const grpc::Status status = Connect()->UseScene(&context, {}, &reply);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(Eventually([&] { return is_stopped.load(); }));
  EXPECT_TRUE(Eventually([&] { return Use().error_code() != grpc::StatusCode::ABORTED; }));
}

TEST_F(SetupCallsTest, ASlaveWithASceneTakesNoOther) {
  slave_.TakeScenes(nullptr);
  const grpc::Status status = Use();
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_NOT_IN_SETUP);
  EXPECT_THAT(status.error_message(), HasSubstr("expected palpate-slave serve --setup"));
}

TEST_F(SetupCallsTest, NobodyOperatesWithoutAManipulator) {
  slave_.TakeNoManipulator();
  const grpc::Status status = Operator(Connect()).Finish();
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_NO_MANIPULATOR);
  EXPECT_THAT(status.error_message(), HasSubstr("manipulator: none"));
  EXPECT_EQ(slave_.begins(), 0);
}

}  // namespace
}  // namespace palpate
