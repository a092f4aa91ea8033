// Paper B, equations (1) to (4) and (6) to (7), against e_contact_distribution.json: contact points
// with both readings of equation (3), nodal forces with both readings of equation (6).
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/contact/surface_contact.h"
#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/localise/localiser.h"
#include "tests/reference/printed_weights.h"
#include "tests/reference/reference_file.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using reference::json;

constexpr double kTolerance = 1e-12;  // the file's, in its units: mm and weights

Vector3d VectorOf(const json& v) {
  return {v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
}
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

void CheckPoint(const json& c) {
  const json& params = c.at("params");
  const json& expected = c.at("expected");
  const std::string status = expected.at("status");
  const auto p = VectorsOf(params.at("electrodes_mm"));
  const auto intensity = params.at("intensity").get<std::vector<double>>();
  const auto point = ContactPointOf(p, intensity);
  ASSERT_EQ(point.has_value(), status == "ok" || status == "undefined_projection");
  if (!point) return;
  EXPECT_LT((point->centroid - VectorOf(expected.at("centroid"))).norm(), kTolerance);
  EXPECT_LT((point->c - VectorOf(expected.at("c"))).norm(), kTolerance);
  const auto place = FingerSurface{params.at("radius_mm")}.Project(point->c);
  ASSERT_EQ(place.has_value(), status == "ok");
  if (place) {
    EXPECT_LT((*place - VectorOf(expected.at("c_sensor"))).norm(), kTolerance);
  }
}

TEST(ContactDistribution, LocatesTheContactAsEquationsOneToFourSay) {
  PALPATE_REFERENCE_OR_SKIP(file, "e_contact_distribution.json");
  EXPECT_GE(ForCases(file, "localise_", CheckPoint), 11);
}

void CheckWeights(const json& c) {
  const json& params = c.at("params");
  const json& expected = c.at("expected");
  const auto corners = VectorsOf(params.at("triangle"));
  const std::array<Vector3d, 3> abc{corners[0], corners[1], corners[2]};
  const Vector3d p = VectorOf(params.at("point")), f = VectorOf(params.at("force"));
  const Vector3d closest = TriangleWeights(p, abc, AreaWeights::kClosest);
  EXPECT_NEAR(closest.sum(), 1, kTolerance);
  EXPECT_GE(closest.minCoeff(), 0);
  const Vector3d exact = TriangleWeights(p, abc, AreaWeights::kSigned);
  const Vector3d printed = TriangleWeights(p, abc, AreaWeights::kUnsigned);
  const std::string status = expected.at("status");
  if (status == "degenerate_triangle") {
    EXPECT_EQ(exact, Vector3d(0, 0, 0));
    EXPECT_EQ(printed, Vector3d(0, 0, 0));
    return;
  }
  EXPECT_LT((exact - VectorOf(expected.at("signed_weights"))).norm(), kTolerance);
  EXPECT_LT((printed - VectorOf(expected.at("unsigned_area_ratios"))).norm(), kTolerance);
  EXPECT_NEAR(printed.sum(), expected.at("unsigned_sum").get<double>(), kTolerance);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d nodal = VectorOf(expected.at("nodal_forces_signed").at(i));
    EXPECT_LT((exact[static_cast<Eigen::Index>(i)] * f - nodal).norm(), kTolerance);
  }
  if (status == "ok") {
    EXPECT_LT((closest - exact).norm(), kTolerance);
  }
}

TEST(ContactDistribution, SharesTheForceAsEquationsSixAndSevenSay) {
  PALPATE_REFERENCE_OR_SKIP(file, "e_contact_distribution.json");
  EXPECT_GE(ForCases(file, "distribute_", CheckWeights), 6);
}

}  // namespace
}  // namespace palpate
