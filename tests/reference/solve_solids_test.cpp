// The solid references through `solve`: scene, loads as files, answers read back.
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "shared/mesh/disc_patch.h"
#include "tests/reference/reference_file.h"
#include "tests/reference/solve_fixture.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using reference::json;

class SolveSolids : public SolveFiles {};

std::string BoxText(const Vector3d& size, const std::array<int, 3>& cells, double E, double nu,
                    double density, const std::string& held_axis, const std::string& model) {
  return "name: reference\nobject:\n  geometry: {box: {size: [" + Text(size.x()) + ", " +
         Text(size.y()) + ", " + Text(size.z()) + "], cells: [" + std::to_string(cells[0]) + ", " +
         std::to_string(cells[1]) + ", " + std::to_string(cells[2]) +
         "]}}\n  material: {young_modulus: " + Text(E) + ", poisson_ratio: " + Text(nu) +
         ", density: " + Text(density) + "}\n  fixed: {plane: {axis: " + held_axis +
         ", at: 0}}\nmodel: {kind: fem, " + model + "}\n";
}

void AppendLoad(const Vector3d& p, const Vector3d& f, std::string* loads) {
  loads->append("1,").append(Text(p.x())).append(",").append(Text(p.y())).append(",");
  loads->append(Text(p.z())).append(",").append(Text(f.x())).append(",").append(Text(f.y()));
  loads->append(",").append(Text(f.z())).append("\n");
}

// Nodal shares of a uniform traction on the triangles whose centroid lies `inside`, a third per
// node (the reference's rule).
std::map<int, double> TractionLoads(const SolidMesh& mesh, double force,
                                    const std::function<bool(const Vector3d&)>& inside) {
  const SurfaceMesh skin = SurfaceOf(mesh);
  std::vector<int> loaded;
  double area = 0;
  for (int t = 0; t < static_cast<int>(skin.triangles.size()); ++t) {
    if (!inside(Centroid(skin, t))) continue;
    loaded.push_back(t);
    area += Area(skin, t);
  }
  std::map<int, double> loads;
  for (const int t : loaded) {
    for (const int node : skin.triangles[static_cast<std::size_t>(t)]) {
      loads[node] += force / area * Area(skin, t) / 3;
    }
  }
  return loads;
}

constexpr const char* kLoads = "case,x,y,z,fx,fy,fz\n";

struct CubeCase {
  const char* answer;
  const char* law;
  double force;  // share of the reference's
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
      const double low = p.at("patch")[0], high = p.at("patch")[1];
      const auto forces = TractionLoads(mesh, F, [&](const Vector3d& q) {
        return q.z() > L * (1 - 1e-9) && q.x() > low && q.x() < high && q.y() > low && q.y() < high;
      });
      std::string loads = kLoads;
      for (const auto& [node, force] : forces) {
        AppendLoad(mesh.nodes[static_cast<std::size_t>(node)], {0, 0, -force}, &loads);
      }
      AppendLoad({L, L, L}, {0, 0, 0}, &loads);
      const auto rows =
          Solve(BoxText({L, L, L}, {n, n, n}, p.at("E"), p.at("nu"), p.at("rho"), "z",
                        std::string("residual: 1e-11, range: 100 %, law: ") + one.law),
                "", loads);
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
    const auto rows = Solve(BoxText({L, L, L}, {n, n, n}, p.at("E"), p.at("nu"), p.at("rho"), "z",
                                    "law: linear, residual: 1e-11, gravity: [0, 0, " +
                                        Text(-p.at("g").get<double>()) + "]"),
                            "", loads);
    const json& corner = c.at("expected").at("linear_gravity").at("u_corner_LLL");
    EXPECT_NEAR(rows[0].at("dz") / corner[2].get<double>(), 1, 1e-8) << id;
  }
}

// Reference: d cantilever_timoshenko: the discrete answers of linear tetrahedra, 1e-8, locking
// included; the load is a uniform traction of the end face.
TEST_F(SolveSolids, TheCantileverGivesTheDiscreteAnswers) {
  PALPATE_REFERENCE_OR_SKIP(file, "d_solid3d.json");
  const json c = reference::CaseOf(file, "cantilever_timoshenko");
  const json& p = c.at("params");
  const double L = p.at("L"), h = p.at("h"), w = p.at("w"), P = p.at("P");
  for (const json& row : c.at("expected").at("linear_tet_discrete")) {
    const int n = row.at("cells_through_height");
    const std::array<int, 3> cells{10 * n, n, n};
    const SolidMesh mesh = MeshBox({L, w, h}, cells);
    for (const auto& [key, deflection] : row.at("mean_tip_deflection").items()) {
      std::string loads = kLoads;
      const auto at_end = [&](const Vector3d& q) { return q.x() > L * (1 - 1e-9); };
      for (const auto& [node, share] : TractionLoads(mesh, P, at_end)) {
        AppendLoad(mesh.nodes[static_cast<std::size_t>(node)], {0, 0, -share}, &loads);
      }
      const auto rows = Solve(BoxText({L, w, h}, cells, p.at("E"), std::stod(key.substr(3)), 1, "x",
                                      "law: linear, residual: 1e-12, range: 100 %"),
                              "", loads);
      double mean = 0;  // along which the load does its work
      for (const auto& answer : rows) mean += answer.at("dz") * answer.at("fz") / P;
      EXPECT_NEAR(mean / deflection.get<double>(), 1, 1e-8) << n << " cells, " << key;
    }
  }
}

}  // namespace
}  // namespace palpate
