// Tests contacts on boundary elements, which are solved by the capacitance matrix of their nodes.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr Bem2dModel::Params kPlain{.young_modulus = 1, .thickness = 1, .range = 10};

struct MovedElements {
  int element;
  Vector2d displacement;  // [length units]
};

// Reference: the problem is solved again with the moved elements as supports with prescribed
// displacements; the capacitance matrix is not used. Tolerance: two factorisations of condition
// 1e2..1e3 in double precision.
void ExpectDirectSolution(const std::string& body, ReferenceProblem problem,
                          const std::vector<MovedElements>& moved) {
  for (const ElementOrder order :
       {ElementOrder::kConstant, ElementOrder::kLinear, ElementOrder::kQuadratic}) {
    problem.order = order;
    Bem2dModel model(problem, kPlain);
    const double unit = problem.mesh.length_unit;
    std::vector<Contact> contacts;
    ReferenceProblem again = problem;
    for (const auto& m : moved) {
      contacts.push_back(bodies::Move(m.element, unit * m.displacement));
      again.held[static_cast<std::size_t>(m.element)] = {true, true};
    }
    const BoundaryState state = bodies::Boundary(model, contacts);
    const GreensFunctions direct(again);
    std::vector<Vector2d> expected(state.traction.size(), Vector2d::Zero());
    double largest = 1;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (int j = 0; j < direct.size(); ++j) {
        for (const auto& m : moved) {
          if (direct.node(j).element != m.element) continue;
          const double* block = direct.block(static_cast<int>(i), j);
          expected[i] += Eigen::Map<const Matrix2d>(block) * m.displacement;
        }
      }
      largest = std::max(largest, expected[i].norm());
    }
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (int c = 0; c < 2; ++c) {
        const bool is_held = direct.held(static_cast<int>(i), c);
        const double solved = is_held ? state.traction[i][c] : state.displacement[i][c] / unit;
        EXPECT_NEAR(solved, expected[i][c], 1e-11 * largest) << body << ", node " << i;
      }
    }
  }
}

TEST(ElementContacts, EqualADirectSolution) {
  ExpectDirectSolution("many contacts", bodies::Block(60),
                       {{20, {-0.2, 0}},
                        {21, {-0.1, 0.05}},
                        {37, {0.01, -0.3}},
                        {38, {0.02, -0.3}},
                        {55, {0.1, 0.1}}});
  ExpectDirectSolution("nu of one half", bodies::Block(60, 1, 0.5),
                       {{37, {0.01, -0.3}}, {20, {-0.1, 0}}});
  ExpectDirectSolution("only contacts hold", bodies::Free(MeshDisc(0.7, 48), 0.3, Plane::kStress),
                       {{5, {0.2, 0}}, {17, {-0.1, -0.2}}, {30, {0, 0.3}}});
}

// Reference: the whole top is moved by hundreds of contacts and, equivalently, by one flat tool
// that reaches beyond its ends: both give the same force, and every contact's answer is that of its
// part of the tool.
TEST(ElementContacts, HundredsEqualTheToolTheyMakeUp) {
  Bem2dModel model(bodies::Block(680), {.young_modulus = 1e6, .thickness = 1});
  const auto& elements = model.greens_functions().problem().mesh.elements;
  const Vector2d moved(1e-3, -1e-3);
  Contact patch = bodies::Move(425, moved);  // at the centre of the top
  patch.p_O.head<2>() = elements[425].a;
  patch.width = 2;  // twice the side
  Solution solution;
  const auto together = bodies::Respond(model, {patch}, &solution).front();
  ASSERT_EQ(together.validity, Validity::kValid);
  const BoundaryState boundary = model.Boundary(solution);
  std::vector<Contact> contacts;
  for (int i = 340; i < 510; ++i) contacts.push_back(bodies::Move(i, moved));
  const auto responses = bodies::Respond(model, contacts);
  Vector2d sum = Vector2d::Zero();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ASSERT_EQ(responses[k].validity, Validity::kValid);
    const Vector2d force = responses[k].force_O.head<2>();
    const std::size_t i = 340 + k;
    EXPECT_LT((force - elements[i].length() * boundary.traction[i]).norm(),
              1e-9 * together.force_O.norm())
        << "element " << i;
    sum += force;
  }
  EXPECT_LT((together.force_O.head<2>() - sum).norm(), 1e-9 * sum.norm());
}

}  // namespace
}  // namespace palpate
