// The references through `solve`: scene, contacts and loads as files, answers read back.
#include <algorithm>
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

// Reference: b_block_embryo.json at its coarsest mesh, all cases, 1e-6.
TEST_F(SolveFiles, BlockAndEmbryoReproduceTheDiscreteReference) {
  PALPATE_REFERENCE_OR_SKIP(file, "b_block_embryo.json");
  int compared = 0;
  for (const auto& c : file.at("cases")) {
    if (!c.contains("constant_element_bem")) continue;
    const json& p = c.at("params");
    const json& by_count = c.at("constant_element_bem").at("k_bar_by_element_count");
    int count = 1 << 20;
    for (const auto& [n, k] : by_count.items()) {
      EXPECT_GT(k.get<double>(), 0);
      count = std::min(count, std::stoi(n));
    }
    const bool block = p.contains("width_m");
    const std::string law = block ? p.at("contact") : p.at("patch_displacement");
    const bool frictionless = law.find("frictionless") == 0 || law.find("t_y=0") != law.npos;
    const std::string model = "elements: " + std::to_string(count) +
                              ", plane: " + p.at("plane").get<std::string>() +
                              ", contact: " + (frictionless ? "frictionless" : "bonded");
    const double E = p.at("youngs_modulus_Pa");
    std::string scene, contacts = "case,x,y,dx,dy,width\n";
    double thickness = 1e-3, depth = 1e-6;
    bool top = false;
    if (block) {
      thickness = p.at("thickness_m");
      depth = 1e-3;
      const double w = p.at("width_m"), h = p.at("height_m");
      const double low = p.at("patch_lo_m"), high = p.at("patch_hi_m");
      top = p.at("indented_side") == "top";
      const std::string middle = Text(0.5 * (low + high));
      const std::string place = top ? middle + "," + Text(h) : Text(w) + "," + middle;
      const std::string moved = top ? "0," + Text(-depth) : Text(-depth) + ",0";
      contacts.append("1,").append(place).append(",").append(moved);
      contacts.append(",").append(Text(high - low)).append("\n");
      scene = SceneText("rectangle: {width: " + Text(w) + ", height: " + Text(h) +
                            ", thickness: " + Text(thickness) + "}",
                        E, p.at("poisson_ratio"), "side: bottom", model);
    } else {
      const double R = p.at("radius_m");
      contacts += "1," + Text(R) + ",0," + Text(-depth) + ",0," +
                  Text(2 * R * p.at("patch_half_angle_rad").get<double>()) + "\n";
      scene = SceneText("disc: {radius: " + Text(R) + ", thickness: " + Text(thickness) + "}", E,
                        p.at("poisson_ratio"),
                        "arc: {centre: " + Text(p.at("hold_arc_centre_rad")) +
                            ", half_angle: " + Text(p.at("hold_arc_half_angle_rad")) + "}",
                        model);
    }
    const auto rows = Solve(scene, contacts, "");
    ASSERT_EQ(rows.size(), 1U) << c.at("id");
    const double k_bar = -rows[0].at(top ? "fy" : "fx") / (E * depth * thickness);
    EXPECT_NEAR(k_bar / by_count.at(std::to_string(count)).get<double>(), 1, 1e-6) << c.at("id");
    ++compared;
  }
  EXPECT_GE(compared, 69);
}

// Reference: the ring's own discrete numbers (1e-6) at 60 elements in all; a polygon with a hole
// that nothing holds, one load per element.
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

// Reference: a rigid translation is exact; contacts hold the left side, loads of nothing act on the
// others, all rows of one case.
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
