// Hundreds of contacts of the planar model.
#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

// Reference: all that can move is moved together, by five hundred contacts and by the one patch
// that they make up: the same force, and every contact's own answer as it is in the patch.
TEST(PlanarStability, FiveHundredContactsEqualThePatchTheyMakeUp) {
  Bem2dModel model(bodies::Block(680), {.young_modulus = 1e6, .thickness = 1});
  const auto& elements = model.greens_functions().problem().mesh.elements;
  const Vector2d moved(1e-3, -1e-3);
  Contact patch = bodies::Move(425, moved);  // in the middle of the top
  patch.p_O.head<2>() = elements[425].a;
  patch.width = 3;  // three sides
  Solution solution;
  const auto together = bodies::Respond(model, {patch}, &solution).front();
  ASSERT_EQ(together.validity, Validity::kValid);
  const BoundaryState boundary = model.Boundary(solution);

  std::vector<Contact> contacts;
  for (int i = 170; i < 680; ++i) contacts.push_back(bodies::Move(i, moved));
  const auto responses = bodies::Respond(model, contacts);
  Vector2d sum = Vector2d::Zero();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ASSERT_EQ(responses[k].validity, Validity::kValid);
    const Vector2d force = responses[k].force_O.head<2>();
    const std::size_t i = 170 + k;
    EXPECT_LT((force - elements[i].length() * boundary.traction[i]).norm(),
              1e-9 * together.force_O.norm())
        << "element " << i;
    sum += force;
  }
  EXPECT_LT((together.force_O.head<2>() - sum).norm(), 1e-9 * sum.norm());
}

}  // namespace
}  // namespace palpate
