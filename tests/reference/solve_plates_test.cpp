// Compares `solve` with the plate references: scene, contacts and loads as files, answers read
// back.
#include <cmath>
#include <string>

#include "tests/reference/reference_file.h"
#include "tests/reference/solve_fixture.h"

namespace palpate {
namespace {

using reference::CaseOf;
using reference::json;

class SolvePlates : public SolveFiles {};

std::string MembraneText(double E, double nu, double a, double t, const std::string& kind) {
  return "name: reference\nobject:\n  geometry: {membrane: {radius: " + Text(a) +
         ", thickness: " + Text(t) + "}}\n  material: {young_modulus: " + Text(E) +
         ", poisson_ratio: " + Text(nu) + "}\n  fixed: {side: rim}\nmodel: {kind: " + kind + "}\n";
}

// Reference: c plate_green_function, 1e-12; a zero load returns the deflection at its place.
TEST_F(SolvePlates, AnEccentricLoadDeflectsThePlateAsTheRecoveredEquationSays) {
  PALPATE_REFERENCE_OR_SKIP(file, "c_plate.json");
  const json c = CaseOf(file, "plate_green_function");
  const json& p = c.at("params");
  const double a = p.at("a"), W = p.at("W");
  std::string loads = "case,x,y,z,fx,fy,fz\n";
  std::vector<double> expected;
  int number = 0;
  for (const json& row : c.at("expected")) {
    const std::string name = std::to_string(number++);
    const double x = row.at("p_over_a").get<double>() * a;
    loads.append(name).append(",").append(Text(x)).append(",0,0,0,0,").append(Text(-1e-3 * W));
    loads.append("\n");
    const bool at_load = row.contains("at_load_point");
    const double r = at_load ? x : row.at("r_over_a").get<double>() * a;
    const double theta = at_load ? 0 : row.at("theta").get<double>();
    if (r == x && theta == 0) {
      expected.push_back(row.at(at_load ? "w_eq1" : "w"));
    } else {
      loads.append(name).append(",").append(Text(r * std::cos(theta))).append(",");
      loads.append(Text(r * std::sin(theta))).append(",0,0,0,0\n");
      expected.push_back(-1);
      expected.push_back(row.at("w"));
    }
  }
  const auto rows = Solve(MembraneText(p.at("E"), p.at("nu"), a, p.at("t"), "plate"), "", loads);
  ASSERT_EQ(rows.size(), expected.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (expected[i] >= 0) {
      EXPECT_NEAR(-rows[i].at("dz") / (1e-3 * expected[i]), 1, 1e-12) << "row " << i;
    }
  }
}

// Reference: c plate_finite_patch: the deflection of the patch's centre, 1e-12.
TEST_F(SolvePlates, ALoadOverASmallCircleDeflectsItsCentreAsTheClosedFormSays) {
  PALPATE_REFERENCE_OR_SKIP(file, "c_plate.json");
  const json c = CaseOf(file, "plate_finite_patch");
  const json& p = c.at("params");
  const double a = p.at("a"), W = p.at("W");
  std::string loads = "case,x,y,z,fx,fy,fz,width\n";
  int number = 0;
  for (const json& row : c.at("expected")) {
    loads.append(std::to_string(number++)).append(",");
    loads.append(Text(row.at("p_over_a").get<double>() * a)).append(",0,0,0,0,");
    loads.append(Text(-1e-3 * W)).append(",");
    loads.append(Text(2 * a * row.at("r0_over_a").get<double>())).append("\n");
  }
  const auto rows = Solve(MembraneText(p.at("E"), p.at("nu"), a, p.at("t"), "plate"), "", loads);
  ASSERT_EQ(rows.size(), c.at("expected").size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double w = c.at("expected")[i].at("w_centre_of_patch");
    EXPECT_NEAR(-rows[i].at("dz") / (1e-3 * w), 1, 1e-12) << c.at("expected")[i];
  }
}

// Reference: c membrane_force_deflection, 1e-5; the linear column is the plate's own closed form.
TEST_F(SolvePlates, ThePapersMembraneHasTheTabulatedForces) {
  PALPATE_REFERENCE_OR_SKIP(file, "c_plate.json");
  const json c = CaseOf(file, "membrane_force_deflection");
  const json& p = c.at("params");
  for (const char* kind : {"plate", "plate-large"}) {
    for (const json& row : c.at("expected")) {
      const std::string contacts = "case,x,y,z,dx,dy,dz,width\n1,0,0,0,0,0," +
                                   Text(-row.at("w0").get<double>()) + "," +
                                   Text(2 * row.at("r0").get<double>()) + "\n";
      const auto rows =
          Solve(MembraneText(p.at("E"), p.at("nu"), p.at("a"), row.at("t"), kind), contacts, "");
      ASSERT_EQ(rows.size(), 1U);
      const bool large = std::string(kind) == "plate-large";
      const double F = row.at(large ? "F_von_karman" : "F_linear");
      EXPECT_NEAR(-rows[0].at("fz") / F, 1, large ? 1e-5 : 1e-12) << kind << row;
    }
  }
}

}  // namespace
}  // namespace palpate
