// Contacts on boundary elements: what the capacitance of their nodes answers.
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
void ExpectDirectSolution(const ReferenceProblem& problem, const std::vector<Moved>& moved) {
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
  double largest = 0;
  for (int i = 0; i < direct.size(); ++i) {
    Vector2d expected = Vector2d::Zero();
    for (const auto& m : moved) {
      expected += Eigen::Map<const Matrix2d>(direct.block(i, m.element)) * m.displacement;
    }
    const auto index = static_cast<std::size_t>(i);
    for (int c = 0; c < 2; ++c) {
      const double solved =
          direct.held(i, c) ? state.traction[index][c] : state.displacement[index][c] / unit;
      EXPECT_NEAR(solved, expected[c], 1e-12 * 10) << "element " << i;
      largest = std::max(largest, std::abs(expected[c]));
    }
  }
  EXPECT_GT(largest, 0.1);
}

TEST(ElementContacts, EqualADirectSolutionForOneContact) {
  ExpectDirectSolution(bodies::Block(60), {{37, {0.01, -0.3}}});
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

// On the block of 60 elements whose sides are 1: a patch of `count` from `first` on.
Contact Wide(Contact contact, int first, int count, const GreensFunctions& greens) {
  const auto& elements = greens.problem().mesh.elements;
  const auto at = [&](int i) { return elements[static_cast<std::size_t>(i)]; };
  contact.element = first + count / 2;
  contact.p_O.head<2>() = 0.5 * (at(first).a + at(first + count - 1).b);
  contact.width = (count - 0.5) * at(first).length();
  return contact;
}

// Reference: loads and contacts are linear, a load's answer under a held neighbour equals the
// boundary solution's mean over the patch, and the answer is the force that the tractions sum to.
TEST(ElementContacts, AnswersAreSumsAndMeansOfTheBoundarySolution) {
  Bem2dModel model(bodies::Block(60), kPlain);
  const GreensFunctions& greens = model.greens_functions();
  const std::vector<Contact> contacts{Wide(bodies::Move(0, {0.01, -0.02}), 36, 3, greens),
                                      Wide(bodies::Load(0, {0.003, 0.001}), 20, 2, greens)};
  Solution solution;
  const auto answer = bodies::Respond(model, contacts, &solution);
  const auto [displacement, traction] = model.Boundary(solution);
  Vector2d force = Vector2d::Zero();
  for (const std::size_t i : {36U, 37U, 38U}) {
    force += greens.lengths()[i] * traction[i];
    EXPECT_LT((displacement[i] - Vector2d(0.01, -0.02)).norm(), 1e-14);
  }
  EXPECT_LT((force - answer[0].force_O.head<2>()).norm(), 1e-13);
  const Vector2d mean = 0.5 * (displacement[20] + displacement[21]);
  EXPECT_LT((mean - answer[1].displacement_O.head<2>()).norm(), 1e-13);
  EXPECT_NEAR(traction[20].x() * (greens.lengths()[20] + greens.lengths()[21]), 0.003, 1e-15);
}

// Reference: superposition; two loads where they overlap do what each does alone, together.
TEST(ElementContacts, LoadsAddUpWhereTheyOverlap) {
  Bem2dModel model(bodies::Block(60), kPlain);
  const GreensFunctions& greens = model.greens_functions();
  const auto solve = [&](const Vector2d& one, const Vector2d& other) {
    Solution solution;
    const auto answer =
        bodies::Respond(model,
                        {bodies::Move(36, {0, 0}), Wide(bodies::Load(0, one), 20, 2, greens),
                         Wide(bodies::Load(0, other), 21, 3, greens)},
                        &solution);
    const auto [displacement, traction] = model.Boundary(solution);
    Vector2d total = Vector2d::Zero();
    for (const std::size_t i : {20U, 21U, 22U, 23U}) total += greens.lengths()[i] * traction[i];
    EXPECT_LT((total - one - other).norm(), 1e-15);
    EXPECT_NEAR(answer[1].displacement_O.x(), 0.5 * (displacement[20] + displacement[21]).x(),
                1e-14);
    std::array<Vector2d, 3> values{answer[0].force_O.head<2>(), answer[1].displacement_O.head<2>(),
                                   answer[2].displacement_O.head<2>()};
    return values;
  };
  const auto first = solve({0.01, 0}, {0, 0});
  const auto second = solve({0, 0}, {0, -0.03});
  const auto both = solve({0.01, 0}, {0, -0.03});
  for (std::size_t i = 0; i < both.size(); ++i) {
    EXPECT_LT((both[i] - first[i] - second[i]).norm(), 1e-14) << i;
  }
}

// Law: what a load puts on elements that a contact holds goes straight to the contact.
TEST(ElementContacts, ALoadPartlyUnderAContactIsSharedWithIt) {
  Bem2dModel model(bodies::Block(60), kPlain);
  const GreensFunctions& greens = model.greens_functions();
  const Contact held = Wide(bodies::Move(0, {0, 0}), 36, 2, greens);
  const Vector2d load(0.01, -0.02);
  const auto both = bodies::Respond(model, {held, Wide(bodies::Load(0, load), 37, 2, greens)});
  const auto beside = bodies::Respond(model, {held, bodies::Load(38, 0.5 * load)});
  ASSERT_EQ(both[0].validity, Validity::kValid) << model.failure();
  EXPECT_LT(((both[0].force_O - beside[0].force_O).head<2>() + 0.5 * load).norm(), 1e-14);
  EXPECT_LT((2 * both[1].displacement_O - beside[1].displacement_O).norm(), 1e-14);
}

TEST(ElementContacts, OnTheSameElementAreRefused) {
  Bem2dModel model(bodies::Block(60), kPlain);
  const GreensFunctions& greens = model.greens_functions();
  const Contact one = Wide(bodies::Move(0, {0, 0}), 36, 2, greens);
  for (const Contact& other :
       {Wide(bodies::Move(0, {0, 0}), 37, 2, greens), bodies::Load(37, {0.01, 0})}) {
    EXPECT_EQ(bodies::Respond(model, {one, other})[0].validity, Validity::kFailed);
    EXPECT_EQ(bodies::Respond(model, {other, one})[0].validity, Validity::kFailed);
  }
}

}  // namespace
}  // namespace palpate
