#include "slave/mechanics/linear/block_inverse.h"

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace palpate {
namespace {

// Blocks chosen from a large matrix, as contacts are from a boundary.
class Chosen {
 public:
  Chosen(int places, int block, unsigned seed)
      : block_(block), all_(Eigen::MatrixXd::Zero(places * block, places * block)) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> entry(-1, 1);
    for (auto& x : all_.reshaped()) x = entry(random) / places;
    all_.diagonal().array() += 3;
    inverse_.Clear(block);
  }

  bool Append(int place) {
    inverse_.Reserve(inverse_.blocks() + 1);
    Write(place);
    places_.push_back(place);
    return inverse_.Append();
  }
  bool Remove(std::size_t k) {
    places_[k] = places_.back();
    places_.pop_back();
    return inverse_.Remove(static_cast<int>(k));
  }
  bool AppendAll(const std::vector<int>& places, bool factors) {
    inverse_.Reserve(static_cast<int>(places.size()));
    for (const int place : places) {
      Write(place);
      places_.push_back(place);
      inverse_.Extend();
    }
    return factors ? inverse_.Factorise() : inverse_.Invert();
  }

  // Largest difference of the inverse from that by Eigen's LU.
  [[nodiscard]] double Error() {
    const int n = inverse_.order();
    Eigen::MatrixXd chosen(n, n), inverse(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        chosen(i, j) = all_(Row(i), Row(j));
        inverse(i, j) = inverse_.Entry(i, j);
      }
    }
    return (chosen.inverse() - inverse).cwiseAbs().maxCoeff();
  }

  [[nodiscard]] bool has(int place) const {
    return std::ranges::find(places_, place) != places_.end();
  }
  [[nodiscard]] std::size_t size() const { return places_.size(); }
  BlockInverse& inverse() { return inverse_; }
  Eigen::MatrixXd& all() { return all_; }

 private:
  [[nodiscard]] int Row(int i) const {
    return places_[static_cast<std::size_t>(i / block_)] * block_ + i % block_;
  }
  void Write(int place) {
    const int n = inverse_.order();
    for (int r = 0; r < block_; ++r) {
      for (int i = 0; i < n; ++i) {
        inverse_.matrix_row(i)[n + r] = all_(Row(i), place * block_ + r);
        inverse_.matrix_row(n + r)[i] = all_(place * block_ + r, Row(i));
      }
      for (int c = 0; c < block_; ++c) {
        inverse_.matrix_row(n + r)[n + c] = all_(place * block_ + r, place * block_ + c);
      }
    }
  }

  int block_;
  Eigen::MatrixXd all_;
  BlockInverse inverse_;
  std::vector<int> places_;
};

class BlockInverseTest : public testing::TestWithParam<int> {};

// Reference: Eigen's LU of the same matrix. Tolerance: the entries are at most one and the
// condition is below ten, so that each of some hundred updates adds a few units of the last place.
TEST_P(BlockInverseTest, EqualsAFreshInverseAfterEveryStep) {
  Chosen chosen(40, GetParam(), 1);
  std::mt19937 random(2);
  for (int step = 0; step < 400; ++step) {
    const int place = std::uniform_int_distribution<int>(0, 39)(random);
    const bool grow = chosen.size() < 2 || (chosen.size() < 30 && step % 3 != 2);
    if (grow && !chosen.has(place)) {
      ASSERT_TRUE(chosen.Append(place));
    } else {
      ASSERT_TRUE(chosen.Remove(static_cast<std::size_t>(place) % chosen.size()));
    }
    ASSERT_LT(chosen.Error(), 1e-12) << "step " << step << ", " << chosen.size() << " blocks";
  }
}

TEST_P(BlockInverseTest, FactorisesWhatWasWrittenAtOnce) {
  Chosen factors(40, GetParam(), 3);
  ASSERT_TRUE(factors.AppendAll({3, 7, 1, 39, 12, 20, 5}, true));
  EXPECT_FALSE(factors.inverse().inverted());
  EXPECT_LT(factors.inverse().Drift(), 1e-14);
  EXPECT_LT(factors.Error(), 1e-14);
  Chosen chosen(40, GetParam(), 3);
  ASSERT_TRUE(chosen.AppendAll({3, 7, 1, 39, 12, 20, 5}, false));
  EXPECT_LT(chosen.Error(), 1e-14);
  ASSERT_TRUE(chosen.Remove(2));
  ASSERT_TRUE(chosen.Append(30));
  EXPECT_LT(chosen.Error(), 1e-13);
}

// Two rows in the wrong order: no pivot without an exchange.
TEST_P(BlockInverseTest, InvertsWhereFactorsWithoutExchangesWouldFail) {
  Chosen chosen(6, GetParam(), 6);
  chosen.all().row(2 * GetParam()).swap(chosen.all().row(4 * GetParam()));
  chosen.all()(2 * GetParam(), 2 * GetParam()) = 0;
  ASSERT_TRUE(chosen.AppendAll({0, 2, 4}, true));
  EXPECT_TRUE(chosen.inverse().inverted());
  EXPECT_LT(chosen.Error(), 1e-14);
}

// Reference: a fault of known size in the matrix, of which the inverse knows nothing.
TEST_P(BlockInverseTest, DriftIsNoticed) {
  Chosen chosen(40, GetParam(), 4);
  ASSERT_TRUE(chosen.AppendAll({3, 7, 1, 39, 12, 20, 5}, false));
  EXPECT_LT(chosen.inverse().Drift(), 1e-14);
  chosen.inverse().matrix_row(2)[1] += 1e-6;
  EXPECT_GT(chosen.inverse().Drift(), 1e-9);
  EXPECT_LT(chosen.inverse().Drift(), 1e-5);
  ASSERT_TRUE(chosen.inverse().Invert());
  EXPECT_LT(chosen.inverse().Drift(), 1e-14);
}

TEST_P(BlockInverseTest, RefusesWhatIsSingularOrNotFinite) {
  for (const double bad : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
    Chosen chosen(6, GetParam(), 5);
    const int row = 4 * GetParam();
    chosen.all().row(row).setConstant(bad);
    ASSERT_TRUE(chosen.Append(1));
    ASSERT_TRUE(chosen.Append(3));
    EXPECT_FALSE(chosen.Append(4)) << bad;
    EXPECT_EQ(chosen.inverse().blocks(), 0);
    Chosen anew(6, GetParam(), 5);
    anew.all().row(row).setConstant(bad);
    EXPECT_FALSE(anew.AppendAll({1, 3, 4}, false)) << bad;
    Chosen factors(6, GetParam(), 5);
    factors.all().row(row).setConstant(bad);
    EXPECT_FALSE(factors.AppendAll({1, 3, 4}, true)) << bad;
  }
}

INSTANTIATE_TEST_SUITE_P(BlockSizes, BlockInverseTest, testing::Values(1, 2, 3, 4, 6));

}  // namespace
}  // namespace palpate
