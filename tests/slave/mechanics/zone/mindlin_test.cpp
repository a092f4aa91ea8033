// A sphere that presses and rubs: Hertz, and Cattaneo and Mindlin's partial slip up to sliding and
// back again (half_space.h).
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/zone/tool_contact.h"
#include "slave/mechanics/fem/zone/zone_set.h"
#include "tests/slave/mechanics/zone/graded_slab.h"
#include "tests/slave/mechanics/zone/half_space.h"

namespace palpate {
namespace {

using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;
using Eigen::VectorXd;

// The contact's law alone, on the exact compliance of an incompressible half-space, where the
// closed forms hold. Small slopes: a contact of a hundredth of the sphere's radius.
class HalfSpaceContact : public testing::Test {
 protected:
  static constexpr double kRadius = 100, kDepth = 0.01, kFriction = 0.3;  // a = 1
  static constexpr double kSide = 1.0 / 6;

  Vector3d Move(const Vector3d& displacement) {
    contact_.Move(displacement);
    for (int k = 0; k < 15; ++k) {
      contact_.FindGaps(W_ * forces_);
      contact_.Solve(VectorXd::Zero(forces_.size()), &forces_);
    }
    contact_.Accept(W_ * forces_);
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < forces_.size(); k += 3) sum += forces_.segment<3>(k);
    return sum;
  }
  // Among the cells that touch and have less than a share of the friction that they could have.
  [[nodiscard]] double RadiusOf(double share) const {
    int count = 0;
    const double least = 0.02 * forces_.cwiseAbs().maxCoeff();  // beyond the solver's tolerance
    for (int k = 0; k < forces_.size(); k += 3) {
      const double pressed = -forces_[k + 2];
      const double most = share * kFriction * pressed;
      count += pressed > least && forces_.segment<2>(k).norm() < most ? 1 : 0;
    }
    return kSide * std::sqrt(count / std::numbers::pi);
  }

  const SphereOnHalfSpace exact_{kRadius, kDepth, 0.5, kFriction};
  const std::vector<Vector3d> cells_ = CellsWithin(1.25, kSide);
  const Eigen::MatrixXd W_ = ComplianceOf(cells_, kSide);
  ToolContact contact_{{.shape = Tool::Shape::kRound, .radius = kRadius},
                       {.p = Vector3d::Zero(), .normal = {0, 0, 1}},
                       kFriction,
                       cells_,
                       W_};
  VectorXd forces_ = VectorXd::Zero(W_.rows());
};

// Tolerances: 1 % of the force for cells of a sixth of the contact's radius; of radii a cell's
// side. Cells that the circle of sticking cuts carry between 0.97 of their friction and all of it.
TEST_F(HalfSpaceContact, ASphereSlipsFromTheRimInwardAsCattaneoAndMindlinHaveIt) {
  const double N = exact_.NormalForce(), most = kFriction * N;
  const Vector3d along(std::cos(0.4), std::sin(0.4), 0);
  for (int k = 1; k <= 3; ++k) Move(-k * kDepth / 3 * Vector3d::UnitZ());
  EXPECT_NEAR(RadiusOf(1e9), exact_.a(), kSide);
  for (int k = 1; k <= 6; ++k) {
    const double way = 0.2 * k * exact_.SlidesAt(), T = exact_.Tangential(way);
    const Vector3d force = Move(way * along - kDepth * Vector3d::UnitZ());
    EXPECT_NEAR(-force.z(), N, 0.01 * N);
    EXPECT_LT((force.head<2>() - T * along.head<2>()).norm(), 0.01 * most) << k;
    if (k < 5) EXPECT_NEAR(RadiusOf(0.97), exact_.StickRadius(T), kSide) << k;
  }
}

// Tolerance: as before.
TEST_F(HalfSpaceContact, ASphereThatTurnsBackFollowsMindlinAndDeresiewicz) {
  const double most = kFriction * exact_.NormalForce(), farthest = 0.7 * exact_.SlidesAt();
  Move({0, 0, -kDepth});
  for (int k = 1; k <= 3; ++k) Move({k * farthest / 3, 0, -kDepth});
  for (int k = 1; k <= 4; ++k) {
    const double way = farthest - 0.35 * k * exact_.SlidesAt();
    const double T = Move({way, 0, -kDepth}).x();
    EXPECT_NEAR(T, exact_.TangentialBack(way, farthest), 0.01 * most) << k;
  }
}

// The whole chain on tetrahedra: a contact of a 200th of the slab's thickness, whose base stiffens
// it by half a percent at nu = 0.4 (Dimitriadis et al., Biophys. J. 82, 2002, eq. 11). Tolerance: 5
// % of the normal force and of mu times it, for nodes 0.15 of the contact's radius apart.
TEST(FineSlab, ASphereSlipsAsCattaneoAndMindlinHaveIt) {
  constexpr double kNu = 0.4, kExtent = 200, kBase = 1.005;  // lengths by the contact's radius
  const SolidMesh mesh = GradedSlab(1.25, 6, kExtent);
  const SphereOnHalfSpace exact{50, 1.0 / 50, kNu, 0.3};
  const double unit = LargerSide(mesh.nodes), N = kBase * exact.NormalForce();
  NearGreen green(
      mesh, FixedWhere(mesh, [&](const Vector3d& p) { return p.z() < -kExtent * (1 - 1e-9); }), kNu,
      std::size_t{1} << 33, {});
  ZoneSet::Touch touch;
  touch.radius = 0.65;  // small strains: nonlinear enough
  touch.contact.tool = Tool{.shape = Tool::Shape::kRound, .radius = 50 / unit};
  touch.contact.friction = exact.mu;
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
    const Vector3d& p = mesh.nodes[Index(n)];
    if (p.z() < -1e-9 || p.norm() > 1.2) continue;
    touch.contact.points.push_back({{static_cast<int>(touch.nodes.size()), 1.0}});
    touch.nodes.push_back(n);
  }
  ZoneSet set(green, mesh, kNu, {touch});
  const auto move = [&](double x, double depth) -> Vector3d {
    const std::vector<VectorXd> way{Vector3d(x, 0, -depth) / unit};
    set.Begin(way);
    for (int k = 0; k < 12; ++k) set.Step(true);
    set.Accept();
    return unit * unit * set.part(0).Force();
  };
  for (int k = 1; k <= 4; ++k) move(0, 0.25 * k * exact.depth);
  const double most = exact.mu * exact.NormalForce(), farthest = 1.2 * exact.SlidesAt();
  for (int k = 1; k <= 6; ++k) {
    const double way = k * farthest / 6;
    const Vector3d force = move(way, exact.depth);
    EXPECT_NEAR(-force.z(), N, 0.05 * N) << k;
    EXPECT_NEAR(force.x(), exact.Tangential(way), 0.05 * most) << k;
  }
  for (int k = 1; k <= 6; ++k) {  // from sliding back: the turn counts from where it began to slide
    const double back = 0.4 * k * exact.SlidesAt(), begun = exact.SlidesAt();
    const Vector3d force = move(farthest - back, exact.depth);
    EXPECT_NEAR(force.x(), exact.TangentialBack(begun - back, begun), 0.05 * most) << k;
  }
}

}  // namespace
}  // namespace palpate
