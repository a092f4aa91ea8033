#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

class StageListener final : public Progress {
 public:
  explicit StageListener(std::string stop_in = "none") : stop_in_(std::move(stop_in)) {}
  void Expect(const PrecomputeCost& cost) override {
    EXPECT_TRUE(stages.empty()) << "before the work starts";
    expected = cost;
  }
  bool Report(std::string_view stage, double done) override {
    EXPECT_GE(done, 0);
    EXPECT_LE(done, 1);
    if (stages.empty() || stages.back() != stage) {
      stages.emplace_back(stage);
    } else {
      EXPECT_GE(done, done_) << stage;
    }
    done_ = done;
    return stage != stop_in_;
  }
  PrecomputeCost expected;
  std::vector<std::string> stages;

 private:
  std::string stop_in_;
  double done_ = 0;
};

constexpr Bem2dModel::Params kParams{.young_modulus = 1e5, .thickness = 1};

TEST(Precompute, ReportsExpectedCostAndProgress) {
  StageListener listener;
  const Bem2dModel model(bodies::Block(60), kParams, &listener);
  const std::vector<std::string> expected{"boundary integrals", "factorising", "solving"};
  EXPECT_EQ(listener.stages, expected);
  EXPECT_GT(listener.expected.seconds, 0);
  EXPECT_GE(listener.expected.memory_bytes, model.info().memory_bytes);
}

TEST(Precompute, StopsOnRequest) {
  for (const char* stage : {"boundary integrals", "factorising", "solving"}) {
    StageListener listener(stage);
    EXPECT_THROW(Bem2dModel(bodies::Block(60), kParams, &listener), Interrupted) << stage;
    EXPECT_EQ(listener.stages.back(), stage);
  }
}

}  // namespace
}  // namespace palpate
