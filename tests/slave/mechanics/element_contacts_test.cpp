// Contacts on boundary elements: what the capacitance of their nodes answers.
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr Bem2dModel::Params kPlain{.young_modulus = 1, .thickness = 1, .range = 10};

struct Moved {
  int element;
  Vector2d displacement;  // [length units]
};

// Reference: the problem solved again with the moved elements among the held ones, whose Green's
// functions give reactions to their displacements: nothing of the capacitance matrix in it.
// Tolerance: two factorisations of condition 1e2..1e3 in double precision.
void ExpectDirectSolution(ReferenceProblem problem, const std::vector<Moved>& moved) {
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
        EXPECT_NEAR(solved, expected[i][c], 1e-11 * largest) << "node " << i;
      }
    }
  }
}

TEST(ElementContacts, EqualADirectSolutionForManyContacts) {
  ExpectDirectSolution(bodies::Block(60), {{20, {-0.2, 0}},
                                           {21, {-0.1, 0.05}},
                                           {37, {0.01, -0.3}},
                                           {38, {0.02, -0.3}},
                                           {55, {0.1, 0.1}}});
}

TEST(ElementContacts, EqualADirectSolutionAtNuOneHalf) {
  ExpectDirectSolution(bodies::Block(60, 1, 0.5), {{37, {0.01, -0.3}}, {20, {-0.1, 0}}});
}

// The body hangs on its contacts alone.
TEST(ElementContacts, EqualADirectSolutionWhereOnlyContactsHold) {
  ExpectDirectSolution(bodies::Free(MeshDisc(0.7, 48), 0.3, Plane::kStress),
                       {{5, {0.2, 0}}, {17, {-0.1, -0.2}}, {30, {0, 0.3}}});
}

}  // namespace
}  // namespace palpate
