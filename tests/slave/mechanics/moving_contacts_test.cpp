#include "slave/mechanics/bem/moving_contacts.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

struct Kind {
  ElementOrder order;
  ContactLaw law;
};

class MovingContactsTest : public testing::TestWithParam<Kind> {
 protected:
  static constexpr int kElements = 160;  // the first 40 are held

  MovingContactsTest() : greens_(Problem()), moving_(greens_), solver_(greens_) {}

  static ReferenceProblem Problem() {
    ReferenceProblem problem = bodies::Block(kElements);
    problem.order = GetParam().order;
    return problem;
  }

  // Contacts on these elements, each in a direction of its own.
  std::vector<ContactPatch> PatchesOn(const std::vector<int>& elements) {
    const int count = greens_.element_nodes().count;
    nodes_.assign(elements.size(), {});
    std::vector<ContactPatch> patches;
    for (std::size_t p = 0; p < elements.size(); ++p) {
      for (int m = 0; m < count; ++m) nodes_[p].push_back(elements[p] * count + m);
      ContactPatch patch{ContactPatch::Law::kBonded, nodes_[p], {0, 0}};
      if (GetParam().law == ContactLaw::kFrictionless) {
        patch.law = ContactPatch::Law::kFrictionless;
        patch.direction = Vector2d(std::cos(elements[p]), std::sin(elements[p]));
      }
      patches.push_back(patch);
    }
    return patches;
  }

  // Largest difference from a factorisation of this very set, over the largest force.
  double DifferenceFromFactorised(const std::vector<int>& elements) {
    const auto patches = PatchesOn(elements);
    EXPECT_TRUE(solver_.Prepare(patches));
    std::vector<double> prescribed(2 * patches.size());
    for (std::size_t v = 0; v < prescribed.size(); ++v) {
      prescribed[v] = std::sin(3.0 * static_cast<double>(v) + 1);
    }
    std::vector<double> updated(prescribed.size()), fresh(prescribed.size());
    moving_.Respond(prescribed, updated);
    EXPECT_TRUE(solver_.Respond(prescribed, fresh));
    double error = 0, largest = 0;
    for (std::size_t v = 0; v < fresh.size(); ++v) {
      error = std::max(error, std::abs(updated[v] - fresh[v]));
      largest = std::max(largest, std::abs(fresh[v]));
    }
    double stiffest = 0, stiffness_error = 0;
    for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
      const auto expected = solver_.Derivative(p);
      stiffest = std::max(stiffest, expected.cwiseAbs().maxCoeff());
      stiffness_error =
          std::max(stiffness_error, (moving_.Derivative(p) - expected).cwiseAbs().maxCoeff());
    }
    return std::max(error / largest, stiffness_error / stiffest);
  }

  GreensFunctions greens_;
  MovingContacts moving_;
  CapacitanceSolver solver_;
  std::vector<std::vector<int>> nodes_;
};

// One contact is added, removed or moved to a random place, ten thousand times; the order in which
// contacts are given changes too. Reference: CapacitanceSolver, which factorises every set anew.
// Tolerance: the drift UpdatedInverse allows, 1e-11, times the condition of the capacitance matrix.
TEST_P(MovingContactsTest, StayEqualToAFactorisationOverTenThousandSteps) {
  const int steps = GetParam().order == ElementOrder::kConstant ? 10000 : 1000;
  std::mt19937 random(7);
  const auto pick = [&](std::size_t below) {
    return std::uniform_int_distribution<std::size_t>(0, below - 1)(random);
  };
  std::vector<int> contacts{50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150, 155, 45};
  double worst = 0;
  for (int step = 0; step < steps; ++step) {
    const int place = 40 + static_cast<int>(pick(120));
    const bool taken = std::ranges::find(contacts, place) != contacts.end();
    const std::size_t kind = pick(3);
    if (kind == 0 && !taken && contacts.size() < 64) {
      contacts.insert(contacts.begin() + static_cast<long>(pick(contacts.size())), place);
    } else if (kind == 1 && contacts.size() > MovingContacts::kFewest) {
      contacts.erase(contacts.begin() + static_cast<long>(pick(contacts.size())));
    } else if (!taken) {
      contacts[pick(contacts.size())] = place;
    }
    ASSERT_TRUE(moving_.Prepare(PatchesOn(contacts))) << step;
    if (step % 10 == 0) worst = std::max(worst, DifferenceFromFactorised(contacts));
  }
  EXPECT_LT(worst, 1e-9);
  EXPECT_GT(moving_.counts().updates, steps / 2);
  EXPECT_LT(moving_.counts().factorisations, steps / 4);
}

// Reference: as above, displacements and tractions of the whole boundary.
TEST_P(MovingContactsTest, GiveTheSameBoundary) {
  std::vector<int> contacts{50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150, 155, 45};
  ASSERT_TRUE(moving_.Prepare(PatchesOn(contacts)));
  contacts[3] = 82;
  ASSERT_TRUE(moving_.Prepare(PatchesOn(contacts)));
  ASSERT_TRUE(solver_.Prepare(PatchesOn(contacts)));
  std::vector<double> prescribed(2 * contacts.size(), 0.01);
  std::vector<Vector2d> displacement, traction, fresh_displacement, fresh_traction;
  moving_.Boundary(prescribed, &displacement, &traction);
  solver_.Boundary(prescribed, &fresh_displacement, &fresh_traction);
  ASSERT_EQ(displacement.size(), fresh_displacement.size());
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    EXPECT_LT((displacement[i] - fresh_displacement[i]).norm(), 1e-13) << i;
    EXPECT_LT((traction[i] - fresh_traction[i]).norm(), 1e-11) << i;
  }
}

TEST_P(MovingContactsTest, LeaveToOthersWhatTheyAreNotFor) {
  std::vector<int> contacts{50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150, 155, 45};
  auto patches = PatchesOn(contacts);
  EXPECT_FALSE(moving_.Prepare(std::span(patches).first(3))) << "few";
  patches[4].law = ContactPatch::Law::kLoad;
  EXPECT_FALSE(moving_.Prepare(patches)) << "a load";
  contacts[4] = 3;
  EXPECT_FALSE(moving_.Prepare(PatchesOn(contacts))) << "on what is held";
  contacts[4] = 60;
  EXPECT_FALSE(moving_.Prepare(PatchesOn(contacts))) << "two on one element";
  contacts[4] = 61;
  EXPECT_TRUE(moving_.Prepare(PatchesOn(contacts)));
  contacts[4] = 60;
  EXPECT_FALSE(moving_.Prepare(PatchesOn(contacts))) << "one moved onto another";
}

INSTANTIATE_TEST_SUITE_P(Kinds, MovingContactsTest,
                         testing::Values(Kind{ElementOrder::kConstant, ContactLaw::kBonded},
                                         Kind{ElementOrder::kConstant, ContactLaw::kFrictionless},
                                         Kind{ElementOrder::kLinear, ContactLaw::kBonded},
                                         Kind{ElementOrder::kQuadratic,
                                              ContactLaw::kFrictionless}));

}  // namespace
}  // namespace palpate
