#include "shared/mesh/node_merger.h"

#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Reference: comparing with every earlier point.
TEST(NodeMergerTest, FindsWhatComparingEveryPairFinds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const double tolerance : {0.0, 1e-9, 0.02, 0.3}) {
    NodeMerger merger(tolerance);
    std::vector<Eigen::Vector3d> places;
    for (int i = 0; i < 3000; ++i) {
      Eigen::Vector3d p(uniform(random), uniform(random), uniform(random));
      if (i % 3 == 1) p = places[static_cast<std::size_t>(i) % places.size()];
      int expected = 0;
      while (expected < static_cast<int>(places.size()) &&
             (places[static_cast<std::size_t>(expected)] - p).norm() > tolerance) {
        ++expected;
      }
      EXPECT_EQ(merger.FindOrAdd(p), expected);
      if (expected == static_cast<int>(places.size())) places.push_back(p);
    }
  }
}

// The ball around the largest number reaches beyond all numbers.
TEST(NodeMergerTest, EndsForTheLargestNumbers) {
  const double most = std::numeric_limits<double>::max();
  NodeMerger merger(2e-7 * most);
  EXPECT_EQ(merger.FindOrAdd({most, 0, 0}), 0);
  EXPECT_EQ(merger.FindOrAdd({-most, most, -most}), 1);
  EXPECT_EQ(merger.FindOrAdd({most, 0, 0}), 0);
}

}  // namespace
}  // namespace palpate
