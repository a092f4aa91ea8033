// Tests the modes and their interaction by laws that do not use their formulas.
#include "slave/mechanics/plate/plate_modes.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/modal_plate.h"
#include "slave/mechanics/plate/round_press.h"

namespace palpate::plate {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kModesNu = 0.45;
constexpr double kD = 1 / (12 * (1 - kModesNu * kModesNu));

VectorXd ModesAt(const PlateModes& modes, const Vector2d& x) {
  VectorXd values(modes.deflections(Symmetry::kNone));
  modes.Evaluate(x, values);
  return values;
}

// Reference: modes that are complete and orthonormal in the bending energy sum to the plate's
// Green's function, sum f_i(p) f_i(x), from below on the diagonal. The remainder is proportional to
// 1 / (order + 4)^2 (the degree including the clamping factor): it falls by 2.56 and 3.06 here.
TEST(PlateModes, AddUpToTheGreensFunction) {
  const Vector2d p(0.4, 0.3);
  double before = 1;
  for (const int order : {6, 12, 24}) {
    const VectorXd f = ModesAt(PlateModes(order, kModesNu), p);
    const double rest = Deflection(p, p) - f.squaredNorm();
    EXPECT_GT(rest, 0);
    EXPECT_LT(rest, before / 2.5);
    before = rest;
  }
  const PlateModes modes(24, kModesNu);
  const Vector2d x(-0.5, 0.2);
  EXPECT_NEAR(ModesAt(modes, p).dot(ModesAt(modes, x)) / Deflection(p, x), 1, 3e-4);
}

double ModalForce(const PlateModes& modes, const Vector2d& place, double R, double w,
                  Symmetry symmetry) {
  ModalPlate plate(modes, kD, 0);
  const ModalPlate::Press press{.disc = {place, R}};
  plate.Place(std::span(&press, 1), symmetry);
  EXPECT_TRUE(plate.Solve(std::span(&w, 1)));
  return plate.AnswerOf(0).force;
}

// Reference: round_press.h, which uses no modes. If no edge of the load lies inside the plate, the
// error falls faster than any power of the order.
TEST(PlateModes, ALoadAllOverConvergesSpectrally) {
  RoundPress exact(kModesNu, 1);
  ASSERT_TRUE(exact.SolveDeflection(3));
  double before = 1;
  for (const int order : {4, 8, 16}) {
    const PlateModes modes(order, kModesNu);
    const double error =
        std::abs(ModalForce(modes, {0, 0}, 1, 3, Symmetry::kMirror) / exact.force() - 1);
    EXPECT_LT(error, before / 10) << order;
    before = error;
  }
  EXPECT_LT(before, 1e-5);
}

// Reference: rotating the plate changes nothing. Off the x axis all modes contribute, sines and
// cosines.
TEST(PlateModes, EveryDirectionIsEquivalent) {
  const PlateModes modes(10, kModesNu);
  const double on_axis = ModalForce(modes, {0.5, 0}, 0.1, 4, Symmetry::kMirror);
  for (const double angle : {0.0, 0.7, 2.0, 4.0}) {
    const Vector2d place = 0.5 * Vector2d(std::cos(angle), std::sin(angle));
    EXPECT_NEAR(ModalForce(modes, place, 0.1, 4, Symmetry::kNone) / on_axis, 1, 1e-10) << angle;
  }
}

}  // namespace
}  // namespace palpate::plate
