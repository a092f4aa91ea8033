#include "slave/mechanics/bem/element_error.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kNoRange = 1e9;

struct Strip {
  double slenderness = 10;  // length 1 over height
  int elements = 180;
  ElementOrder order = ElementOrder::kConstant;
  double nu = 0.3;
  Plane plane = Plane::kStress;
  double angle = 0;
  double unit = 1;  // length [m]
};

// A strip that is held at its left end.
ReferenceProblem ProblemOf(const Strip& strip) {
  const double height = strip.unit / strip.slenderness;
  ReferenceProblem problem{
      MeshRectangle(strip.unit, height, strip.elements), {}, strip.nu, strip.plane, strip.order};
  for (auto& e : problem.mesh.elements) {
    const bool held = e.midpoint().x() < 1e-9 * strip.unit;
    problem.held.push_back({held, held});
    e.a = Eigen::Rotation2Dd(strip.angle) * e.a;
    e.b = Eigen::Rotation2Dd(strip.angle) * e.b;
  }
  return problem;
}

// The response to a load on the whole free end, across (bending) or along the strip; its
// displacement in x by force, length, E and thickness of one.
ContactResponse LoadEnd(const Strip& strip, bool bends) {
  Bem2dModel model(ProblemOf(strip), {.young_modulus = 1, .thickness = 1, .range = kNoRange});
  const Eigen::Rotation2Dd turn(strip.angle);
  const double height = strip.unit / strip.slenderness;
  const Vector2d end = turn * Vector2d(strip.unit, height / 2);
  const Vector2d force = 1e-9 * strip.unit * (turn * (bends ? Vector2d(0, 1) : Vector2d(1, 0)));
  const Contact load =
      contacts::Push({end.x(), end.y(), 0}, {force.x(), force.y(), 0}, 1.0001 * height);
  ContactResponse response = contacts::Answer(model, load);
  response.displacement_O.x() = response.displacement_O.head<2>().dot(force) / force.squaredNorm();
  return response;
}

// Reference: Timoshenko's beam with E / (1 - nu^2) in plane strain; up to 30:1 also quadratic
// elements, because the clamped end makes short strips stiffer. A valid answer is within 5 %.
TEST(ElementError, AStripThatBendsIsWithinFivePerCentOrExtrapolated) {
  for (const ElementOrder order : bodies::kOrders) {
    int valid = 0, flagged = 0;
    for (const double slenderness : {2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 300.0, 1000.0}) {
      for (const int elements : {60, 180}) {
        if (elements > 60 && order == ElementOrder::kQuadratic) continue;
        Strip strip{.slenderness = slenderness, .elements = elements, .order = order};
        const double a = slenderness;
        double exact = 4 * std::pow(a, 3) + 1.2 * a * 2 * (1 + strip.nu);
        if (a < 30) {
          Strip fine = strip;
          fine.elements = 90;
          fine.order = ElementOrder::kQuadratic;
          exact = LoadEnd(fine, true).displacement_O.x();
        }
        const ContactResponse bent = LoadEnd(strip, true);
        const double off = std::abs(bent.displacement_O.x() / exact - 1);
        const bool is_valid = bent.validity == Validity::kValid;
        EXPECT_LT(is_valid ? off : 0, 0.05) << a << ":1, " << elements;
        EXPECT_TRUE(is_valid || bent.flag_reason == kCoarseElements) << bent.flag_reason;
        (is_valid ? valid : flagged) += 1;
      }
    }
    EXPECT_GT(flagged, 1) << static_cast<int>(order);
    EXPECT_EQ(valid > 5, order != ElementOrder::kConstant) << static_cast<int>(order);
  }
}

// Reference: Hooke's law for a bar, and quadratic elements for short strips, where the clamped end
// matters.
TEST(ElementError, AStripThatIsPressedIsWithinFivePerCentOrExtrapolated) {
  for (const ElementOrder order : bodies::kOrders) {
    int valid = 0;
    for (const double slenderness : {1.0, 5.0, 10.0, 30.0, 100.0, 300.0, 1000.0}) {
      for (const double nu : {0.0, 0.49}) {
        Strip strip{.slenderness = slenderness, .elements = 120, .order = order, .nu = nu};
        const ContactResponse pressed = LoadEnd(strip, false);
        strip.order = ElementOrder::kQuadratic;
        strip.elements = 60;
        const double exact =
            slenderness < 30 ? LoadEnd(strip, false).displacement_O.x() : slenderness;
        const double off = std::abs(pressed.displacement_O.x() / exact - 1);
        const bool is_valid = pressed.validity == Validity::kValid;
        EXPECT_LT(is_valid ? off : 0, 0.05) << slenderness << ":1, nu = " << nu;
        valid += is_valid ? 1 : 0;
      }
    }
    EXPECT_GT(valid, order == ElementOrder::kConstant ? 1 : 12) << static_cast<int>(order);
  }
}

// Laws: the estimate does not depend on size or orientation. It depends on Poisson's ratio and on
// plane stress or strain, but a valid answer stays within 5 % of quadratic elements.
TEST(ElementError, HoldsForOtherMaterialsSizesAndDirections) {
  for (const ElementOrder order : {ElementOrder::kConstant, ElementOrder::kLinear}) {
    for (const double nu : {-0.4, 0.3, 0.495}) {
      for (const Plane plane : {Plane::kStress, Plane::kStrain}) {
        for (const double slenderness : {2.0, 25.0}) {
          Strip strip{
              .slenderness = slenderness, .elements = 90, .order = order, .nu = nu, .plane = plane};
          const ContactResponse bent = LoadEnd(strip, true);
          Strip turned = strip;
          turned.angle = 0.7;
          turned.unit = 1e-5;
          EXPECT_EQ(LoadEnd(turned, true).validity, bent.validity);
          strip.order = ElementOrder::kQuadratic;
          const double exact = LoadEnd(strip, true).displacement_O.x();
          const double off = std::abs(bent.displacement_O.x() / exact - 1);
          EXPECT_LT(bent.validity == Validity::kValid ? off : 0, 0.05)
              << slenderness << ":1, nu = " << nu;
        }
      }
    }
  }
}

// A square of side 1 that is held at its bottom, with an arm of length 1 and height 0.05 at the
// upper end of its right side. Reference: the same with quadratic elements. Constant elements are
// right on the square and far too stiff on the arm.
TEST(ElementError, FlagsTheSlenderPartOfABodyOnly) {
  const auto problem = [](ElementOrder order) {
    const Outline outline{{{0, 0}, {1, 0}, {1, 0.95}, {2, 0.95}, {2, 1}, {0, 1}}, {}};
    ReferenceProblem made{MeshPolygon(outline, 240), {}, 0.49, Plane::kStress, order};
    for (const auto& e : made.mesh.elements) {
      const bool held = e.midpoint().y() < 1e-9;
      made.held.push_back({held, held});
    }
    return made;
  };
  const Bem2dModel::Params params{.young_modulus = 1, .thickness = 1, .range = kNoRange};
  Bem2dModel model(problem(ElementOrder::kConstant), params);
  Bem2dModel exact(problem(ElementOrder::kQuadratic), params);
  const auto press = [](Bem2dModel& on, double x, double width) {
    return contacts::Answer(on, contacts::Push({x, 1, 0}, {0, -1e-9, 0}, width));
  };
  const ContactResponse on_square = press(model, 0.4, 0.1), on_arm = press(model, 1.9, 0.1);
  EXPECT_EQ(on_square.validity, Validity::kValid) << on_square.flag_reason;
  EXPECT_NEAR(on_square.displacement_O.y() / press(exact, 0.4, 0.1).displacement_O.y(), 1, 0.05);
  EXPECT_EQ(on_arm.flag_reason, kCoarseElements);
  EXPECT_LT(on_arm.displacement_O.y() / press(exact, 1.9, 0.1).displacement_O.y(), 0.7);
  EXPECT_EQ(press(exact, 1.9, 0.1).validity, Validity::kValid);
}

}  // namespace
}  // namespace palpate
