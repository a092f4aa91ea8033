#include "slave/mechanics/bem/pivoted_lu.h"

#include <string>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

// Reference: Eigen's own LU; sizes on both sides of every block. Tolerance: the condition of these
// matrices is below 1e5.
TEST(PivotedLu, SolvesAsEigenDoes) {
  for (const int n : {1, 2, 15, 16, 17, 33, 100, 300}) {
    const Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n);
    const Eigen::MatrixXd B = Eigen::MatrixXd::Random(n, 280);
    Eigen::MatrixXd factorised = A;
    Eigen::MatrixXd solved = B;
    const PivotedLu lu(&factorised, {nullptr, ""});
    lu.Solve(&solved, {nullptr, ""});
    EXPECT_LT((A * solved - B).norm(), 1e-10 * B.norm() * std::max(1.0, solved.norm())) << n;
    const Eigen::MatrixXd expected = A.partialPivLu().solve(B);
    EXPECT_LT((solved - expected).norm(), 1e-9 * expected.norm()) << n;
  }
}

// Reference: the norms themselves. An estimate is never above the condition, and as a rule within a
// factor of three.
TEST(PivotedLu, EstimatesTheCondition) {
  for (const int n : {5, 40, 150}) {
    for (const double smallest : {1.0, 1e-4, 1e-10}) {
      Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n) + n * Eigen::MatrixXd::Identity(n, n);
      A.row(n / 2) = A.row(0) + smallest * Eigen::RowVectorXd::Random(n);
      const auto norm = [](const Eigen::MatrixXd& m) {
        return m.cwiseAbs().colwise().sum().maxCoeff();
      };
      const double condition = norm(A) * norm(A.inverse());
      Eigen::MatrixXd factorised = A;
      const double estimate = 1 / PivotedLu(&factorised, {nullptr, ""}).ReciprocalCondition();
      EXPECT_LE(estimate, condition * 1.001) << n << ' ' << smallest;
      EXPECT_GE(estimate, condition / 3) << n << ' ' << smallest;
    }
  }
  Eigen::MatrixXd singular = Eigen::MatrixXd::Zero(20, 20);
  EXPECT_EQ(PivotedLu(&singular, {nullptr, ""}).ReciprocalCondition(), 0);
}

class Listener final : public Progress {
 public:
  explicit Listener(std::string stop_in = "none") : stop_in_(std::move(stop_in)) {}
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

TEST(Precompute, TellsWhatToExpectAndHowFarItIs) {
  Listener listener;
  const Bem2dModel model(bodies::Block(60), kParams, &listener);
  const std::vector<std::string> expected{"boundary integrals", "factorising", "solving"};
  EXPECT_EQ(listener.stages, expected);
  EXPECT_GT(listener.expected.seconds, 0);
  EXPECT_GE(listener.expected.memory_bytes, model.info().memory_bytes);
}

TEST(Precompute, StopsWhereItIsTold) {
  for (const char* stage : {"boundary integrals", "factorising", "solving"}) {
    Listener listener(stage);
    EXPECT_THROW(Bem2dModel(bodies::Block(60), kParams, &listener), Interrupted) << stage;
    EXPECT_EQ(listener.stages.back(), stage);
  }
}

// Reference: the number of unknowns by order, 2 N, 4 N and 6 N.
TEST(Precompute, CostsMoreForHigherOrders) {
  const auto memory = [](int elements, ElementOrder order) {
    return static_cast<double>(Bem2dModel::Estimate(elements, order).memory_bytes);
  };
  const double constant = memory(500, ElementOrder::kConstant);
  EXPECT_EQ(memory(500, ElementOrder::kLinear) / constant, 4);
  EXPECT_EQ(memory(500, ElementOrder::kQuadratic) / constant, 9);
  EXPECT_EQ(memory(1000, ElementOrder::kConstant) / constant, 4);
}

}  // namespace
}  // namespace palpate
