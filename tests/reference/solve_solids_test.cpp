// Compares `solve` with the solid references: scene and loads as files, answers read back.
#include <cmath>
#include <map>
#include <string>

#include "shared/mesh/disc_patch.h"
#include "tests/reference/reference_file.h"
#include "tests/reference/solve_fixture.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using reference::json;

class SolveSolids : public SolveFiles {};

std::string CubeText(const json& params, const std::string& model) {
  const std::string side = Text(params.at("L")),
                    n = std::to_string(params.at("mesh").at("n").get<int>());
  return "name: reference\nobject:\n  geometry: {box: {size: [" + side + ", " + side + ", " + side +
         "], cells: [" + n + ", " + n + ", " + n +
         "]}}\n  material: {young_modulus: " + Text(params.at("E")) +
         ", poisson_ratio: " + Text(params.at("nu")) + ", density: " + Text(params.at("rho")) +
         "}\n  fixed: {plane: {axis: z, at: 0}}\nmodel: {kind: fem, residual: 1e-11, " + model +
         "}\n";
}

void AppendLoad(const Vector3d& p, const Vector3d& f, std::string* loads) {
  loads->append("1,").append(Text(p.x())).append(",").append(Text(p.y())).append(",");
  loads->append(Text(p.z())).append(",").append(Text(f.x())).append(",").append(Text(f.y()));
  loads->append(",").append(Text(f.z())).append("\n");
}

// Nodal shares of a uniform traction on the triangles of the top whose centroid lies in the patch,
// a third per node (the reference's rule).
std::map<int, double> TractionLoads(const SolidMesh& mesh, double force, const json& params) {
  const double side = params.at("L"), low = params.at("patch")[0], high = params.at("patch")[1];
  const SurfaceMesh skin = SurfaceOf(mesh);
  std::map<int, double> loads;
  double area = 0;
  for (int t = 0; t < static_cast<int>(skin.triangles.size()); ++t) {
    const Vector3d p = Centroid(skin, t);
    const auto inside = [&](double x) { return x > low && x < high; };
    if (p.z() < side * (1 - 1e-9) || !inside(p.x()) || !inside(p.y())) continue;
    area += Area(skin, t);
    for (const int node : skin.triangles[static_cast<std::size_t>(t)]) {
      loads[node] += force * Area(skin, t) / 3;
    }
  }
  for (auto& [node, load] : loads) load /= area;
  return loads;
}

constexpr const char* kLoads = "case,x,y,z,fx,fy,fz\n";

struct CubeCase {
  const char* answer;
  const char* law;
  double force;  // relative to the reference's force
  double tolerance;
};

// Reference: d cube_n3, n6, n12: the discrete answers of a prescribed mesh, linear 1e-8,
// co-rotational 1e-6 relative.
TEST_F(SolveSolids, TheFoamCubeGivesTheDiscreteAnswers) {
  PALPATE_REFERENCE_OR_SKIP(file, "d_solid3d.json");
  for (const char* id : {"cube_n3", "cube_n6", "cube_n12"}) {
    const json c = reference::CaseOf(file, id);
    const json& p = c.at("params");
    const double L = p.at("L");
    const int n = p.at("mesh").at("n");
    const SolidMesh mesh = MeshBox({L, L, L}, {n, n, n});
    for (const CubeCase& one :
         {CubeCase{"linear_patch", "linear", 1, 1e-8},
          CubeCase{"corotational_patch_quarter_force", "corotational", 0.25, 1e-6},
          CubeCase{"corotational_patch_full_force", "corotational", 1, 1e-6}}) {
      if (!c.at("expected").contains(one.answer)) continue;
      const json& expected = c.at("expected").at(one.answer);
      const double F = p.at("total_force_N").get<double>() * one.force;
      const auto forces = TractionLoads(mesh, F, p);
      std::string loads = kLoads;
      for (const auto& [node, force] : forces) {
        AppendLoad(mesh.nodes[static_cast<std::size_t>(node)], {0, 0, -force}, &loads);
      }
      AppendLoad({L, L, L}, {0, 0, 0}, &loads);
      const auto rows = Solve(CubeText(p, std::string("range: 100 %, law: ") + one.law), "", loads);
      ASSERT_EQ(rows.size(), forces.size() + 1);
      const json& corner = expected.at("u_corner_LLL");
      const double size = std::abs(corner[2].get<double>());
      EXPECT_NEAR(rows.back().at("dx"), corner[0], one.tolerance * size) << id << one.answer;
      EXPECT_NEAR(rows.back().at("dz"), corner[2], one.tolerance * size) << id << one.answer;
      double work = 0;
      for (const auto& row : rows) work += row.at("dz") * row.at("fz") / F;
      EXPECT_NEAR(work / expected.at("mean_patch_depth").get<double>(), 1, one.tolerance)
          << id << one.answer;
    }
    std::string loads = kLoads;
    AppendLoad({L, L, L}, {0, 0, 0}, &loads);
    const std::string gravity =
        "law: linear, gravity: [0, 0, " + Text(-p.at("g").get<double>()) + "]";
    const auto rows = Solve(CubeText(p, gravity), "", loads);
    const json& corner = c.at("expected").at("linear_gravity").at("u_corner_LLL");
    EXPECT_NEAR(rows[0].at("dz") / corner[2].get<double>(), 1, 1e-8) << id;
  }
}

}  // namespace
}  // namespace palpate
