// The condensed rest of a body against the elimination that it stands for.
#include "slave/mechanics/fem/zone/linear_rest.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/zone/pressed_slab.h"

namespace palpate {
namespace {

using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::MatrixXd;

// K of all tetrahedra that are not the zone's, by the linear law, held components with a unit
// diagonal.
MatrixXd StiffnessOutside(const Slab& slab, const Zone& zone) {
  std::vector<std::array<int, 4>> outside;
  for (std::size_t t = 0; t < slab.mesh.tets.size(); ++t) {
    if (!std::ranges::binary_search(zone.tets, static_cast<int>(t))) {
      outside.push_back(slab.mesh.tets[t]);
    }
  }
  const NeoHookeanTets tets(outside, slab.positions, slab.nu);
  const int unknowns = 3 * static_cast<int>(slab.mesh.nodes.size());
  const VectorXd rest = VectorXd::Zero(unknowns);
  MatrixXd K = MatrixXd::Zero(unknowns, unknowns);
  NeoHookeanTets::Block block;
  for (int t = 0; t < tets.size(); ++t) {
    tets.Stiffness(t, rest.data(), &block);
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        K.block<3, 3>(3 * tets.corners(t)[Index(a)], 3 * tets.corners(t)[Index(b)]) +=
            block.block<3, 3>(3 * a, 3 * b);
      }
    }
  }
  for (int i = 0; i < unknowns; ++i) {
    const bool held = slab.held[Index(i / 3)][Index(i % 3)];
    if (held) K.row(i).setZero(), K.col(i).setZero();
    if (held || K.row(i).isZero(0)) K(i, i) = 1;
  }
  return K;
}

// Dense elimination of everything outside. The compliances of neighbours differ little, so that
// their inverse loses five of sixteen digits.
TEST(LinearRest, IsTheSchurComplementOfWhatIsOutside) {
  const Slab slab(6, 0.4);
  LinearRest rest(slab.mesh, slab.held, slab.nu);
  const ZoneFinder finder(slab.mesh);
  // One within the surface, one at the edge that reaches the base.
  const Zone inner = finder.Around({0.04, 0.04, 0.04}, 0.018, {});
  const Zone low = finder.Around({0.0, 0.04, 0.01}, 0.02, {});
  const auto condensed = rest.Condense({inner, low});
  for (const auto& [zone, S] : {std::pair(inner, condensed[0]), std::pair(low, condensed[1])}) {
    ASSERT_GT(zone.inner, 0);
    const MatrixXd K = StiffnessOutside(slab, zone);
    std::vector<int> border, other;
    for (int b = zone.inner; b < zone.size(); ++b) {
      for (int c = 0; c < 3; ++c) border.push_back(3 * zone.nodes[Index(b)] + c);
    }
    for (int i = 0; i < K.rows(); ++i) {
      if (std::ranges::find(border, i) == border.end()) other.push_back(i);
    }
    MatrixXd expected = K(border, border);
    expected -= K(border, other) * K(other, other).llt().solve(MatrixXd(K(other, border)));
    for (std::size_t i = 0; i < border.size(); ++i) {
      const int at = static_cast<int>(i);
      if (slab.held[Index(border[i] / 3)][Index(border[i] % 3)]) expected(at, at) = 0;
    }
    EXPECT_LT((S - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
  }
}

// Work done twice for shared nodes or once is the same.
TEST(LinearRest, ZonesDoNotDependOnTheirCompany) {
  const Slab slab(8, 0.3);
  LinearRest rest(slab.mesh, slab.held, slab.nu);
  const ZoneFinder finder(slab.mesh);
  const Zone a = finder.Around({0.03, 0.04, 0.04}, 0.018, {});
  const Zone b = finder.Around({0.04, 0.04, 0.04}, 0.018, {});
  const MatrixXd alone = rest.Condense({b}).front();
  EXPECT_LT((rest.Condense({a, b})[1] - alone).norm(), 1e-10 * alone.norm());
}

}  // namespace
}  // namespace palpate
