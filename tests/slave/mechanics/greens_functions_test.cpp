#include "slave/mechanics/bem/greens_functions.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

TEST(GreensFunctions, CountTheRigidMotionsThatAreLeftFree) {
  ReferenceProblem problem = bodies::Block(40);
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 0);
  // X is fixed along the bottom: translation along y and rotation remain free.
  for (auto& held : problem.held) held[1] = false;
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 2);
  for (auto& held : problem.held) held = {false, false};
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 3);
  problem.held[3] = {true, true};  // a held element does not turn
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 0);
}

std::string RefusalOfProblem(const ReferenceProblem& problem) {
  return Thrown<std::invalid_argument>([&] { const GreensFunctions greens(problem); });
}

TEST(GreensFunctions, RefuseWhatCannotBeSolved) {
  ReferenceProblem all_held = bodies::Free(MeshDisc(1, 20), 0.5, Plane::kStrain);
  for (auto& held : all_held.held) held = {true, true};
  EXPECT_THAT(RefusalOfProblem(all_held), testing::HasSubstr("whole boundary"));
  all_held.nu = 0.49;
  EXPECT_EQ(RefusalOfProblem(all_held), "");
  using P = ReferenceProblem;
  const std::vector<std::pair<void (*)(P*), const char*>> mistakes{
      {[](P* p) { p->nu = 0.51; }, "-1 < nu <= 0.5"},
      {[](P* p) { p->nu = std::nan(""); }, "-1 < nu <= 0.5"},
      {[](P* p) { p->mesh.elements[2].b = p->mesh.elements[2].a; }, "without length"},
      {[](P* p) { p->mesh.elements.resize(2); }, "3 or more"},
      {[](P* p) { p->mesh.length_unit = 0; }, "length unit"},
      {[](P* p) { p->mesh.elements[1] = p->mesh.elements[0]; }, "singular"}};  // held twice there
  for (const auto& [change, words] : mistakes) {
    ReferenceProblem problem = bodies::Block(8);
    change(&problem);
    EXPECT_THAT(RefusalOfProblem(problem), testing::HasSubstr(words));
  }
}

}  // namespace
}  // namespace palpate
