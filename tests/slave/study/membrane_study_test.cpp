// A study of the rubber membrane against the published von Karman curves of the reference set,
// which were derived with another program.
#include <cmath>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_law.h"
#include "slave/study/study.h"
#include "tests/support/references.h"

namespace palpate::study {
namespace {

using reference::json;

Scene PublishedMembrane(const json& params, double thickness, double depth) {
  Scene scene;
  scene.object.geometry = MembraneGeometry{params.at("a"), thickness};
  scene.object.material.young_modulus = params.at("E");
  scene.object.material.poisson_ratio = params.at("nu");
  scene.tool = Tool{};
  scene.tool->width = 1e-6;  // a point, as in the published curves
  scene.operator_options.press_depth = depth;
  return scene;
}

// The ratio of the linear plate's force to von Karman's is published, and the error of that law
// relative to a solid is known (plate_law.h), so the true error is known; users are promised a
// factor of 1.5. The large-deformation model must agree with the published force to 1e-3, since its
// load is no point.
TEST(MembraneStudyTest, StatedErrorsAndReferenceAgreeWithThePublishedCurves) {
  PALPATE_CASE_OR_SKIP(published, "c_plate.json", "membrane_force_deflection");
  int compared = 0;
  for (const json& point : published.at("expected")) {
    const double t = point.at("t"), depth = point.at("w0");
    const bool chosen = t == 0.001 || depth == 0.005;
    if (point.at("r0") != 0.0 || !chosen) continue;
    SCOPED_TRACE("t = " + std::to_string(t) + ", w0 = " + std::to_string(depth));
    StudySettings settings;
    settings.timing_s = 0;
    settings.places = {Eigen::Vector3d::Zero()};
    const Scene scene = PublishedMembrane(published.at("params"), t, depth);
    const StudyResult study = RunStudy(scene, settings, DefaultModelFactory());
    const double force = point.at("F_von_karman");
    const double radius = std::get<MembraneGeometry>(scene.object.geometry).radius;
    const double solid = 1 + plate::ExcessAtDepth({0, depth / radius, t / radius});
    const double error = std::abs(point.at("linear_over_von_karman").get<double>() * solid - 1);
    EXPECT_NEAR(study.references.presses.at(0).full.value * solid / force, 1, 1e-3);
    ASSERT_EQ(study.rows.size(), 6U) << "a plate that bends, five with modes";
    for (const StudyRow& row : study.rows) {
      ASSERT_EQ(row.outcome, Outcome::kAnswered) << row.reason;
      if (row.family == "plate") {
        EXPECT_LT(row.error.value, 1.5 * error);
        EXPECT_GT(row.error.value, error / 1.5);
      } else {
        const double off = std::abs(row.answers.at(0).full.value / force - 1);
        EXPECT_LT(off, 1e-3);
        EXPECT_NEAR(row.error.value, solid - 1, 2e-3 * solid);
      }
      ++compared;
    }
  }
  EXPECT_EQ(compared, 6 * (10 + 3));
}

}  // namespace
}  // namespace palpate::study
