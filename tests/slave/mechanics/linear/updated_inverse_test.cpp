#include "slave/mechanics/linear/updated_inverse.h"

#include <limits>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::MatrixXd;

// Unknowns of an imaginary body: the entry between two is a function of both, so that any choice of
// them makes a matrix with a positive definite symmetric part, as a compliance does.
class Unknowns {
 public:
  Unknowns(int count, bool symmetric) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> side(-1, 1);
    const auto R = MatrixXd::NullaryExpr(count, count + 5, [&] { return side(random); }).eval();
    all_ = R * R.transpose() / count + 0.05 * MatrixXd::Identity(count, count);
    const auto S = MatrixXd::NullaryExpr(count, count, [&] { return side(random); }).eval();
    if (!symmetric) all_ += 0.2 * (S - S.transpose()) / std::sqrt(count);
  }
  [[nodiscard]] double operator()(int i, int j) const { return all_(i, j); }
  [[nodiscard]] MatrixXd Of(const std::vector<int>& chosen) const { return all_(chosen, chosen); }

 private:
  MatrixXd all_;
};

double Error(const UpdatedInverse& inverse, const MatrixXd& matrix) {
  const MatrixXd P = matrix.inverse();
  double error = 0;
  for (int i = 0; i < inverse.order(); ++i) {
    for (int j = 0; j < inverse.order(); ++j) {
      error = std::max(error, std::abs(inverse.inverse_row(i)[j] - P(i, j)));
    }
  }
  return error / P.cwiseAbs().maxCoeff();
}

bool Start(UpdatedInverse& inverse, const MatrixXd& matrix) {
  const int order = static_cast<int>(matrix.rows());
  inverse.Reset(order);
  for (int i = 0; i < order; ++i) {
    for (int j = 0; j < order; ++j) inverse.row(i)[j] = matrix(i, j);
  }
  return inverse.Invert();
}

class UpdatedInverseTest : public testing::TestWithParam<bool> {};

// Reference: Eigen's pivoted LU. Condition numbers are near 1e3: 1e-12 leaves one digit.
TEST_P(UpdatedInverseTest, InvertsEveryOrder) {
  const Unknowns unknowns(70, GetParam());
  UpdatedInverse inverse(GetParam());
  std::vector<int> chosen;
  for (int order = 1; order <= 70; ++order) {
    chosen.push_back(order - 1);
    ASSERT_TRUE(Start(inverse, unknowns.Of(chosen)));
    EXPECT_LT(Error(inverse, unknowns.Of(chosen)), 1e-12) << order;
  }
}

// Ten thousand times unknowns come, go or give way to others, one to twelve at a time and in one or
// two places, between orders 0 and 90. Reference: a fresh LU. The probe allows 1e-11 per component;
// the worst entry measured is far below 1e-9.
TEST_P(UpdatedInverseTest, TenThousandRandomStepsDoNotDrift) {
  const int pool = 160;
  const Unknowns unknowns(pool, GetParam());
  std::mt19937 random(11);
  const auto dice = [&](int sides) {
    return static_cast<int>(random() % static_cast<unsigned>(sides));
  };
  std::vector<int> chosen, spare;
  for (int i = 0; i < pool; ++i) (i < 90 ? chosen : spare).push_back(i);
  UpdatedInverse inverse(GetParam());
  ASSERT_TRUE(Start(inverse, unknowns.Of(chosen)));  // room for ninety
  double worst = 0;
  for (int step = 0; step < 10000; ++step) {
    const int order = static_cast<int>(chosen.size());
    const int first = dice(order + 1);
    const int removed = std::min(dice(13), order - first);
    const int inserted = std::min(dice(13), 90 - order + removed);
    const auto at = chosen.begin() + first;
    spare.insert(spare.begin(), at, at + removed);
    chosen.erase(at, at + removed);
    chosen.insert(chosen.begin() + first, spare.end() - inserted, spare.end());
    spare.resize(spare.size() - static_cast<std::size_t>(inserted));
    ASSERT_TRUE(inverse.Splice(first, removed, inserted));
    const int now = static_cast<int>(chosen.size());
    ASSERT_EQ(inverse.order(), now);
    for (int i = first; i < first + inserted; ++i) {
      for (int j = 0; j < now; ++j) {
        const int a = chosen[static_cast<std::size_t>(i)], b = chosen[static_cast<std::size_t>(j)];
        inverse.row(i)[j] = unknowns(a, b);
        if (!GetParam()) inverse.row(j)[i] = unknowns(b, a);
      }
    }
    ASSERT_TRUE(inverse.Border(first, inserted));
    ASSERT_TRUE(inverse.Settle());
    if (step % 50 == 0 && now > 0) worst = std::max(worst, Error(inverse, unknowns.Of(chosen)));
  }
  EXPECT_LT(worst, 1e-9);
  EXPECT_LT(inverse.inversions(), 10) << worst;  // one measured
}

// Two ranges are taken out before either is put in again.
TEST_P(UpdatedInverseTest, SeveralRangesChangeTogether) {
  const Unknowns unknowns(60, GetParam());
  std::vector<int> chosen;
  for (int i = 0; i < 40; ++i) chosen.push_back(i);
  UpdatedInverse inverse(GetParam());
  ASSERT_TRUE(Start(inverse, unknowns.Of(chosen)));
  for (int k = 0; k < 3; ++k) {
    chosen[static_cast<std::size_t>(5 + k)] = 45 + k;
    chosen[static_cast<std::size_t>(30 + k)] = 50 + k;
  }
  ASSERT_TRUE(inverse.Splice(5, 3, 3));
  ASSERT_TRUE(inverse.Splice(30, 3, 3));
  const MatrixXd matrix = unknowns.Of(chosen);
  for (const int first : {5, 30}) {
    for (int i = first; i < first + 3; ++i) {
      for (int j = 0; j < 40; ++j) {
        inverse.row(i)[j] = matrix(i, j);
        if (!GetParam()) inverse.row(j)[i] = matrix(j, i);
      }
    }
    ASSERT_TRUE(inverse.Border(first, 3));
  }
  ASSERT_TRUE(inverse.Settle());
  EXPECT_EQ(inverse.inversions(), 1);
  EXPECT_LT(Error(inverse, matrix), 1e-12);
}

TEST_P(UpdatedInverseTest, TellsWhatIsSingularAndWhatIsNoNumber) {
  UpdatedInverse inverse(GetParam());
  const Unknowns unknowns(12, GetParam());
  std::vector<int> chosen{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  MatrixXd matrix = unknowns.Of(chosen);
  matrix.row(7) = matrix.row(2);
  matrix.col(7) = matrix.col(2);
  EXPECT_FALSE(Start(inverse, matrix));
  matrix = unknowns.Of(chosen);
  matrix(9, 4) = matrix(4, 9) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Start(inverse, matrix));
  EXPECT_FALSE(Start(inverse, MatrixXd::Zero(2, 2)));
  ASSERT_TRUE(Start(inverse, unknowns.Of(chosen)));  // and nothing of it stays
  EXPECT_LT(Error(inverse, unknowns.Of(chosen)), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Symmetry, UpdatedInverseTest, testing::Bool(),
                         [](const auto& kind) { return kind.param ? "Symmetric" : "General"; });

}  // namespace
}  // namespace palpate
