// The moment of a contact's force about the contact's centre.
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "tests/slave/mechanics/bodies.h"
#include "tests/slave/mechanics/contacts.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBlockSide = 0.088;
constexpr Bem2dModel::Params kSilicone{.young_modulus = 127e3, .thickness = 9e-3};

Bem2dModel& BlockOf(int elements, ElementOrder order) {
  static std::map<std::pair<int, ElementOrder>, std::unique_ptr<Bem2dModel>> made;
  auto& model = made[{elements, order}];
  if (!model) {
    ReferenceProblem problem = bodies::Block(elements, kBlockSide, 0.49, Plane::kStress);
    problem.order = order;
    model = std::make_unique<Bem2dModel>(std::move(problem), kSilicone);
  }
  return *model;
}

ContactResponse Punch(Bem2dModel& model, double x, double width, const Vector2d& moved) {
  Contact contact = bodies::Move(-1, moved);
  contact.p_O = {x, kBlockSide, 0};
  contact.width = width;
  return bodies::Respond(model, {contact})[0];
}

// Reference: the same bonded flat punch with at least six times as many elements. Places are
// between the centre and half a width from the corner, at and between the ends of elements.
TEST(ContactMoment, OfABondedFlatPunchIsWithin5PercentOfForceTimesWidth) {
  Bem2dModel& fine = BlockOf(1440, ElementOrder::kConstant);
  int eccentric = 0;
  for (const double width : {5.9e-3, 12e-3}) {
    for (const double x : {0.0441, 0.03, 0.017, 0.0098, 0.0063}) {
      if (x < width / 2) continue;  // the punch would extend around the corner
      for (const Vector2d& moved : {Vector2d(0, -1e-3), Vector2d(5e-4, -1e-3)}) {
        const ContactResponse should = Punch(fine, x, width, moved);
        ASSERT_TRUE(should.moment_O);
        eccentric += std::abs(should.moment_O->z()) > 0.02 * should.force_O.norm() * width ? 1 : 0;
        for (const auto& [elements, order] : {std::pair{60, ElementOrder::kQuadratic},
                                              {120, ElementOrder::kConstant},
                                              {120, ElementOrder::kLinear},
                                              {240, ElementOrder::kConstant},
                                              {240, ElementOrder::kQuadratic}}) {
          const ContactResponse is = Punch(BlockOf(elements, order), x, width, moved);
          ASSERT_TRUE(is.moment_O) << elements;
          const double off = (*is.moment_O - *should.moment_O).norm();
          const double scale = should.force_O.norm() * width;
          EXPECT_LT(off, 0.05 * scale) << elements << " at " << x << ", width " << width;
          EXPECT_LT(off, 3 * is.moment_sigma) << elements << " at " << x << ", width " << width;
          EXPECT_LT(is.moment_sigma, 0.11 * scale);
        }
      }
    }
  }
  EXPECT_GT(eccentric, 4);
}

TEST(ContactMoment, OfOneConstantElementOrOfAPointIsUnknown) {
  EXPECT_FALSE(Punch(BlockOf(60, ElementOrder::kConstant), 0.0147, 2e-3, {0, -1e-3}).moment_O);
  EXPECT_FALSE(Punch(BlockOf(120, ElementOrder::kConstant), 0.017, 0, {0, -1e-3}).moment_O);
}

// Law: equilibrium: the supports' moment about the contact's place is the negative.
TEST(ContactMoment, BalancesTheSupports) {
  Bem2dModel& model = BlockOf(240, ElementOrder::kQuadratic);
  const double width = 12e-3;
  Contact contact = bodies::Move(-1, {5e-4, -1e-3});
  contact.p_O = {0.017, kBlockSide, 0};
  contact.width = width;
  Solution solution;
  model.Solve({&contact, 1}, &solution);
  const ContactResponse& response = solution.responses()[0];
  const BoundaryState state = model.Boundary(solution);
  double moment = 0, size = 0;  // of all tractions about the contact's place
  for (int i = 0; i < model.greens_functions().size(); ++i) {
    const BoundaryNode& node = model.greens_functions().node(i);
    if (node.p_O.y() > 1e-6) continue;  // a support is at the bottom
    const Vector2d force = state.traction[static_cast<std::size_t>(i)] * node.length *
                           model.greens_functions().problem().mesh.length_unit * 9e-3;
    const Vector2d arm = node.p_O - contact.p_O.head<2>();
    moment += arm.x() * force.y() - arm.y() * force.x();
    size += arm.norm() * force.norm();
  }
  ASSERT_TRUE(response.moment_O);
  EXPECT_NEAR(response.moment_O->z(), -moment, 0.01 * size);
}

std::unique_ptr<DeformationModel> CubeModel(const std::string& kind, int cells, bool quadratic) {
  Scene scene;
  scene.object.geometry = BoxGeometry{{1, 1, 1}, {cells, cells, cells}};
  scene.object.material = {.young_modulus = 1, .poisson_ratio = 0.3, .density = 1};
  scene.object.fixed = {Fixed{FixedPlane{2, 0}, {true, true, true}}};
  scene.model.kind = kind;
  scene.model.range = 1;
  if (quadratic) scene.model.fem.element = FemOptions::Element::kTet10;
  return MakeModel(scene, MeshObject(scene, std::nullopt));
}

// Reference: fem-green with a third of the edge length. The disc lies completely on the top or
// extends over its edge. Flagged answers are not compared.
TEST(ContactMoment, OfADiscOnASolidIsWithin5PercentOfForceTimesWidth) {
  const auto fine = CubeModel("fem-green", 24, false);
  int valid = 0;
  struct Mesh {
    std::string kind;
    int cells;
    bool quadratic;
  };
  for (const Mesh& mesh :
       {Mesh{"fem-green", 12, false}, Mesh{"fem", 10, false}, Mesh{"fem", 9, true}}) {
    const auto model = CubeModel(mesh.kind, mesh.cells, mesh.quadratic);
    for (const Vector3d& p_O :
         {Vector3d(0.5, 0.5, 1), Vector3d(0.71, 0.5, 1), Vector3d(0.76, 0.5, 1),
          Vector3d(0.78, 0.62, 1), Vector3d(0.9, 0.5, 1)}) {
      const double width = 0.4;
      const Contact press = contacts::Move(p_O, {5e-5, 0, -1e-4}, width);
      const ContactResponse should = contacts::Query(*fine, press),
                            is = contacts::Query(*model, press);
      ASSERT_TRUE(should.moment_O && is.moment_O) << mesh.kind;
      if (is.validity != Validity::kValid) continue;
      ++valid;
      const double scale = should.force_O.norm() * width;
      const double share = should.force_O.norm() / is.force_O.norm();
      const double off = (share * *is.moment_O - *should.moment_O).norm();
      EXPECT_LT(off, 0.05 * scale) << mesh.kind << " " << p_O.transpose();
      EXPECT_LT(off, 3 * is.moment_sigma) << mesh.kind << " " << p_O.transpose();
    }
    // Law: a uniform load acts at the centroid of the part of the disc that lies on the surface.
    const Vector3d load(0, 0, -1e-3);
    const ContactResponse whole =
        contacts::Query(*model, contacts::Push({0.71, 0.5, 1}, load, 0.4));
    ASSERT_TRUE(whole.moment_O);
    EXPECT_LT(whole.moment_O->norm(), 1e-9 * load.norm());
    // The disc without the segment beyond the edge.
    const double r = 0.2, d = 0.02, chord = std::sqrt(r * r - d * d);
    const ContactResponse cut =
        contacts::Query(*model, contacts::Push({1 - d, 0.5, 1}, load, 2 * r));
    ASSERT_TRUE(cut.moment_O);
    const double left = std::numbers::pi * r * r - r * r * std::acos(d / r) + d * chord;
    const double arm = 2.0 / 3 * std::pow(chord, 3) / left;
    EXPECT_NEAR(cut.moment_O->y(), -arm * 1e-3, 1e-6 * arm * 1e-3) << cut.moment_O->transpose();
  }
  EXPECT_GE(valid, 11);  // of 15
}

}  // namespace
}  // namespace palpate
