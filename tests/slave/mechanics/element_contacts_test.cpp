#include "slave/mechanics/bem/capacitance_solver.h"

#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

struct Moved {
  int element;
  Vector2d displacement;
};

// Reference: the problem solved anew with the moved elements among the held ones, whose Green's
// functions give reactions to their displacements: nothing of the capacitance matrix in it.
// Tolerance: two factorisations of condition 1e2..1e3 in double precision.
void ExpectDirectSolution(const ReferenceProblem& problem, const std::vector<Moved>& moved) {
  const GreensFunctions greens(problem);
  CapacitanceSolver solver(greens);
  std::vector<std::vector<int>> elements;
  std::vector<double> prescribed;
  ReferenceProblem anew = problem;
  for (const auto& m : moved) {
    elements.push_back({m.element});
    prescribed.insert(prescribed.end(), {m.displacement.x(), m.displacement.y()});
    anew.held[static_cast<std::size_t>(m.element)] = {true, true};
  }
  std::vector<ContactPatch> patches;
  for (const auto& e : elements) patches.push_back({ContactPatch::Law::kBonded, e});
  ASSERT_TRUE(solver.Prepare(patches));
  std::vector<double> force(prescribed.size());
  ASSERT_TRUE(solver.Respond(prescribed, force));
  std::vector<Vector2d> displacement, traction;
  solver.Boundary(prescribed, &displacement, &traction);

  const GreensFunctions direct(anew);
  double largest = 0;
  for (int i = 0; i < direct.size(); ++i) {
    Vector2d expected = Vector2d::Zero();
    for (const auto& m : moved) {
      expected += Eigen::Map<const Matrix2d>(direct.block(i, m.element)) * m.displacement;
    }
    const auto index = static_cast<std::size_t>(i);
    for (int c = 0; c < 2; ++c) {
      const Vector2d& solved = direct.held(i, c) ? traction[index] : displacement[index];
      EXPECT_NEAR(solved[c], expected[c], 1e-12 * 10) << "element " << i;
      largest = std::max(largest, std::abs(expected[c]));
    }
  }
  EXPECT_GT(largest, 0.1);
}

TEST(CapacitanceSolver, EqualsADirectSolutionForOneContact) {
  ExpectDirectSolution(bodies::Block(60), {{37, {0.01, -0.3}}});
}

TEST(CapacitanceSolver, EqualsADirectSolutionForManyContacts) {
  ExpectDirectSolution(bodies::Block(60), {{20, {-0.2, 0}},
                                           {21, {-0.1, 0.05}},
                                           {37, {0.01, -0.3}},
                                           {38, {0.02, -0.3}},
                                           {55, {0.1, 0.1}}});
}

TEST(CapacitanceSolver, EqualsADirectSolutionAtNuOneHalf) {
  ExpectDirectSolution(bodies::Block(60, 1, 0.5), {{37, {0.01, -0.3}}, {20, {-0.1, 0}}});
}

// The body hangs on its contacts alone.
TEST(CapacitanceSolver, EqualsADirectSolutionWhereOnlyContactsHold) {
  ExpectDirectSolution(bodies::Free(MeshDisc(0.7, 48), 0.3, Plane::kStress),
                       {{5, {0.2, 0}}, {17, {-0.1, -0.2}}, {30, {0, 0.3}}});
}

// Reference: loads and contacts are linear, a load's answer under a held neighbour equals the
// boundary solution's mean over the patch, and the answer is the force that the tractions sum to.
TEST(CapacitanceSolver, AnswersAreSumsAndMeansOfTheBoundarySolution) {
  const GreensFunctions greens(bodies::Block(60));
  CapacitanceSolver solver(greens);
  const std::vector<int> held{36, 37, 38};
  const std::vector<int> loaded{20, 21};
  const std::vector<ContactPatch> patches{{ContactPatch::Law::kBonded, held},
                                          {ContactPatch::Law::kLoad, loaded}};
  ASSERT_TRUE(solver.Prepare(patches));
  const std::vector<double> prescribed{0.01, -0.02, 0.003, 0.001};
  std::vector<double> answer(4);
  ASSERT_TRUE(solver.Respond(prescribed, answer));
  std::vector<Vector2d> displacement, traction;
  solver.Boundary(prescribed, &displacement, &traction);
  Vector2d force = Vector2d::Zero();
  for (const std::size_t i : {36U, 37U, 38U}) {
    force += greens.lengths()[i] * traction[i];
    EXPECT_LT((displacement[i] - Vector2d(0.01, -0.02)).norm(), 1e-14);
  }
  EXPECT_LT((force - Vector2d(answer[0], answer[1])).norm(), 1e-13);
  const Vector2d mean = 0.5 * (displacement[20] + displacement[21]);
  EXPECT_LT((mean - Vector2d(answer[2], answer[3])).norm(), 1e-13);
  EXPECT_NEAR(traction[20].x() * (greens.lengths()[20] + greens.lengths()[21]), 0.003, 1e-15);
}

// Reference: superposition; two loads where they overlap do what each does alone, together.
TEST(CapacitanceSolver, LoadsAddUpWhereTheyOverlap) {
  const GreensFunctions greens(bodies::Block(60));
  const std::vector<int> held{36}, one{20, 21}, other{21, 22, 23};
  const auto solve = [&](std::vector<double> prescribed) {
    CapacitanceSolver solver(greens);
    const std::vector<ContactPatch> patches{{ContactPatch::Law::kBonded, held},
                                            {ContactPatch::Law::kLoad, one},
                                            {ContactPatch::Law::kLoad, other}};
    EXPECT_TRUE(solver.Prepare(patches));
    std::vector<double> answer(6);
    EXPECT_TRUE(solver.Respond(prescribed, answer));
    std::vector<Vector2d> displacement, traction;
    solver.Boundary(prescribed, &displacement, &traction);
    Vector2d total = Vector2d::Zero();
    for (const std::size_t i : {20U, 21U, 22U, 23U}) total += greens.lengths()[i] * traction[i];
    EXPECT_NEAR(total.x(), prescribed[2] + prescribed[4], 1e-15);
    EXPECT_NEAR(answer[2], 0.5 * (displacement[20] + displacement[21]).x(), 1e-14);
    return answer;
  };
  const auto first = solve({0, 0, 0.01, 0, 0, 0});
  const auto second = solve({0, 0, 0, 0, -0.03, 0});
  const auto both = solve({0, 0, 0.01, 0, -0.03, 0});
  for (std::size_t i = 0; i < both.size(); ++i) EXPECT_NEAR(both[i], first[i] + second[i], 1e-14);
}

TEST(CapacitanceSolver, RefusesAContactsElementInAnotherPatch) {
  const GreensFunctions greens(bodies::Block(60));
  CapacitanceSolver solver(greens);
  const std::vector<int> one{36, 37};
  const std::vector<int> other{37, 38};
  const std::vector<ContactPatch> patches{{ContactPatch::Law::kBonded, one},
                                          {ContactPatch::Law::kBonded, other}};
  EXPECT_FALSE(solver.Prepare(patches));
  const std::vector<ContactPatch> with_load{{ContactPatch::Law::kBonded, one},
                                            {ContactPatch::Law::kLoad, other}};
  EXPECT_FALSE(solver.Prepare(with_load));
  const std::vector<ContactPatch> load_first{{ContactPatch::Law::kLoad, one},
                                             {ContactPatch::Law::kBonded, other}};
  EXPECT_FALSE(solver.Prepare(load_first));
}

}  // namespace
}  // namespace palpate
