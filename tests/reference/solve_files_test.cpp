// Compares `solve` with the references: scene, contacts and loads as files, answers read back.
#include <cmath>
#include <string>

#include "tests/reference/reference_file.h"
#include "tests/reference/solve_fixture.h"
#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using reference::json;

std::string SceneText(const std::string& geometry, double E, double nu, const std::string& fixed,
                      const std::string& model) {
  return "name: reference\nobject:\n  geometry: {" + geometry +
         "}\n  material: {young_modulus: " + Text(E) + " Pa, poisson_ratio: " + Text(nu) + "}\n" +
         (fixed.empty() ? "" : "  fixed: {" + fixed + "}\n") + "model: {kind: bem2d, " + model +
         "}\n";
}

// Reference: the discrete solution of the ring (1e-6) with 60 elements in total; a polygon with a
// hole, without supports, with one load per element.
TEST_F(SolveFiles, ARingUnderPressureReproducesTheDiscreteReference) {
  PALPATE_REFERENCE_OR_SKIP(file, "a_elastostatics2d.json");
  const json c = reference::CaseOf(file, "lame_cylinder_plane_strain");
  const json& p = c.at("params");
  const BoundaryMesh ring = bodies::Ring(p.at("a"), p.at("b"), 30);
  std::string outer, inner, loads = "case,x,y,fx,fy\n";
  for (int i = 0; i < 60; ++i) {
    const auto& e = ring.elements[static_cast<std::size_t>(i)];
    std::string& points = i < 30 ? outer : inner;
    points.append(points.empty() ? "[" : ", [");
    points.append(Text(e.a.x())).append(", ").append(Text(e.a.y())).append("]");
    if (i < 30) continue;
    const Eigen::Vector2d f = -p.at("pi_").get<double>() * 0.01 * e.length() * e.normal();
    loads += "1," + Text(e.midpoint().x()) + "," + Text(e.midpoint().y()) + "," + Text(f.x()) +
             "," + Text(f.y()) + "\n";
  }
  const auto rows = Solve(
      SceneText("polygon: {points: [" + outer + "], holes: [[" + inner + "]], thickness: 10 mm}",
                p.at("E"), p.at("nu"), "", "elements: 60, plane: strain"),
      "", loads);
  ASSERT_EQ(rows.size(), 30U);
  const double exact = c.at("expected").at(0).at("u_r");
  const double own = c.at("cross_check")
                         .at("own_constant_bem_internal_pressure_only")
                         .at("60")
                         .at("u_a_over_exact");
  for (const auto& row : rows) {
    EXPECT_NEAR(std::hypot(row.at("dx"), row.at("dy")) / exact, own, 1e-6);
  }
}

// Reference: a rigid translation is exact. Contacts move the left side, zero loads act on the
// others; all rows belong to one case.
TEST_F(SolveFiles, ARigidTranslationIsExact) {
  const BoundaryMesh mesh = MeshRectangle(0.2, 0.1, 60);
  std::string contacts = "case,x,y,dx,dy\n", loads = "case,x,y,fx,fy\n";
  for (const auto& e : mesh.elements) {
    const std::string place = "1," + Text(e.midpoint().x()) + "," + Text(e.midpoint().y());
    (e.normal().x() < -0.5 ? contacts : loads) +=
        place + (e.normal().x() < -0.5 ? ",2e-4,-4e-4\n" : ",0,0\n");
  }
  const auto rows = Solve(SceneText("rectangle: {width: 0.2, height: 0.1, thickness: 1}", 2e5, 0.3,
                                    "", "elements: 60, plane: strain"),
                          contacts, loads);
  ASSERT_EQ(rows.size(), 60U);
  for (const auto& row : rows) {
    EXPECT_NEAR(row.at("dx"), 2e-4, 1e-15);
    EXPECT_NEAR(row.at("dy"), -4e-4, 1e-15);
    EXPECT_NEAR(row.at("fx"), 0, 1e-9);
  }
}

}  // namespace
}  // namespace palpate
