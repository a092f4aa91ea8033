// Paper B, equations (6) and (7), against e_contact_distribution.json: nodal forces.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/contact/surface_contact.h"
#include "tests/reference/reference_file.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using reference::json;
using reference::VectorOf;

constexpr double kTolerance = 1e-12;  // the file's, in its units: mm and weights

std::vector<Vector3d> VectorsOf(const json& rows) {
  std::vector<Vector3d> vectors;
  for (const json& row : rows) vectors.push_back(VectorOf(row));
  return vectors;
}

// Counts the cases of a kind, so that a file without them does not pass.
int ForCases(const json& file, const std::string& prefix, void (*check)(const json& c)) {
  int count = 0;
  for (const json& c : file.at("cases")) {
    const std::string id = c.at("id");
    if (id.rfind(prefix, 0) != 0) continue;
    SCOPED_TRACE(id);
    check(c);
    ++count;
  }
  return count;
}

// Inside of the triangle the weights are the areas; outside they are those of the closest point,
// never negative.
void CheckWeights(const json& c) {
  const json& params = c.at("params");
  const json& expected = c.at("expected");
  const auto corners = VectorsOf(params.at("triangle"));
  const Vector3d w = ClosestOnTriangle(VectorOf(params.at("point")),
                                       {corners[0], corners[1], corners[2]}, {true, true, true})
                         .weights;
  EXPECT_NEAR(w.sum(), 1, kTolerance);
  EXPECT_GE(w.minCoeff(), 0);
  if (expected.at("status") != "ok") return;
  const Vector3d f = VectorOf(params.at("force"));
  for (int i = 0; i < 3; ++i) {
    const auto nodal = VectorOf(expected.at("nodal_forces_signed").at(static_cast<std::size_t>(i)));
    EXPECT_LT((w[i] * f - nodal).norm(), kTolerance);
  }
}

TEST(ContactDistribution, SharesTheForceAsEquationsSixAndSevenSay) {
  PALPATE_REFERENCE_OR_SKIP(file, "e_contact_distribution.json");
  EXPECT_GE(ForCases(file, "distribute_", CheckWeights), 6);
}

}  // namespace
}  // namespace palpate
