// Paper B's foam objects: three meshes, three materials, weight and a press.
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "tests/slave/mechanics/fem/solids.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using solids::Respond;

const std::filesystem::path kFolder = SourcePath("/../shared/data/seed001_meshes");

SolidMesh Read(const std::string& name) {
  std::ifstream nodes(kFolder / (name + ".node")), tets(kFolder / (name + ".ele"));
  SolidMesh mesh;
  int count = 0, skipped = 0, id = 0;
  nodes >> count >> skipped >> skipped >> skipped;
  for (int i = 0; i < count; ++i) {
    Vector3d p;
    nodes >> id >> p.x() >> p.y() >> p.z();
    mesh.nodes.push_back(p);
  }
  tets >> count >> skipped >> skipped;
  for (int i = 0; i < count; ++i) {
    std::array<int, 4> tet{};
    tets >> id >> tet[0] >> tet[1] >> tet[2] >> tet[3] >> skipped;
    for (int& node : tet) --node;
    mesh.tets.push_back(tet);
  }
  return mesh;
}

// The list counts degrees of freedom from 1.
solids::Held ReadHeld(const std::string& name, std::size_t nodes) {
  std::ifstream stream(kFolder / "constrained_nodes.yaml");
  solids::Held held(nodes);
  std::string text((std::istreambuf_iterator<char>(stream)), {});
  const auto begin = text.find("\n" + name + ":") == std::string::npos
                         ? text.find(name + ":")
                         : text.find("\n" + name + ":");
  const auto open = text.find('[', begin), close = text.find(']', open);
  std::string list = text.substr(open + 1, close - open - 1);
  for (char& c : list) c = c == ',' ? ' ' : c;
  std::istringstream numbers(list);
  for (std::size_t dof = 0; numbers >> dof;) held.at((dof - 1) / 3)[(dof - 1) % 3] = true;
  return held;
}

// Displacements by another formulation: strains in Voigt's notation from the inverse of the
// barycentric matrix, Eigen's LDL^T of the free rows.
std::vector<Vector3d> IndependentLinear(const SolidMesh& mesh, const solids::Held& held,
                                        const Material& material, const Eigen::VectorXd& f) {
  const double E = material.young_modulus, nu = material.poisson_ratio;
  Eigen::Matrix<double, 6, 6> C = Eigen::Matrix<double, 6, 6>::Zero();
  C.topLeftCorner<3, 3>().setConstant(nu);
  C.diagonal().head<3>().setConstant(1 - nu);
  C.diagonal().tail<3>().setConstant(0.5 - nu);
  C *= E / ((1 + nu) * (1 - 2 * nu));
  std::vector<Eigen::Triplet<double>> entries;
  const auto is_held = [&](int d) {
    return held[static_cast<std::size_t>(d / 3)][static_cast<std::size_t>(d % 3)];
  };
  for (const auto& tet : mesh.tets) {
    Eigen::Matrix4d rest;
    for (std::size_t i = 0; i < 4; ++i) {
      rest.row(static_cast<Eigen::Index>(i)) << 1,
          mesh.nodes[static_cast<std::size_t>(tet[i])].transpose();
    }
    const Eigen::Matrix4d shape = rest.inverse();
    Eigen::Matrix<double, 6, 12> B = Eigen::Matrix<double, 6, 12>::Zero();
    for (int i = 0; i < 4; ++i) {
      const Vector3d g = shape.col(i).tail<3>();
      B.block<6, 3>(0, 3 * i) << g.x(), 0, 0, 0, g.y(), 0, 0, 0, g.z(), g.y(), g.x(), 0, 0, g.z(),
          g.y(), g.z(), 0, g.x();
    }
    const Eigen::Matrix<double, 12, 12> K = rest.determinant() / 6 * B.transpose() * C * B;
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 12; ++j) {
        const int row = 3 * tet[static_cast<std::size_t>(i / 3)] + i % 3;
        const int column = 3 * tet[static_cast<std::size_t>(j / 3)] + j % 3;
        if (!is_held(row) && !is_held(column)) entries.emplace_back(row, column, K(i, j));
      }
    }
  }
  Eigen::VectorXd free = f;
  for (int d = 0; d < f.size(); ++d) {
    if (!is_held(d)) continue;
    entries.emplace_back(d, d, 1);
    free[d] = 0;
  }
  Eigen::SparseMatrix<double> K(f.size(), f.size());
  K.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd u = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(K).solve(free);
  std::vector<Vector3d> displacement;
  for (int i = 0; i < u.size(); i += 3) displacement.push_back(u.segment<3>(i));
  return displacement;
}

// Weight of every node and the press, a uniform pressure on the triangles of its patch.
Eigen::VectorXd Loads(const SolidMesh& mesh, const Contact& press, const Vector3d& weight) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const double V = SignedVolume(mesh, static_cast<int>(e));
    for (const int i : mesh.tets[e]) f.segment<3>(3 * i) += V / 4 * weight;
  }
  const SurfaceMesh surface = SurfaceOf(mesh);
  const auto patch = PatchAt(surface, *FindPlace(surface, press.p_O), press.p_O, press.width);
  double area = 0;
  for (const int t : patch.triangles) area += Area(surface, t);
  for (const int t : patch.triangles) {
    for (const int i : surface.triangles[static_cast<std::size_t>(t)]) {
      f.segment<3>(3 * i) += Area(surface, t) / area / 3 * press.prescribed_O;
    }
  }
  return f;
}

// Reference: IndependentLinear, to the rounding of two direct solutions. The co-rotational answer
// exists too, and is flagged exactly where elements are inside out.
TEST(FoamObjects, AnswerUnderWeightAndAPressOfOneNewton) {
  if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "../shared/data is absent";
  const std::map<std::string, Vector3d> places{
      {"cube", {0.06, 0.03, 0.03}}, {"sponge", {0.06, 0.025, 0.02}}, {"bar", {0.18, 0.02, 0.04}}};
  const std::map<std::string, Vector3d> directions{
      {"cube", {-1, 0, 0}}, {"sponge", {0, 0, -1}}, {"bar", {0, 0, -1}}};
  const std::array<Material, 3> materials{{{3800, 0.15, 45}, {3200, 0.15, 30}, {3000, 0.15, 26}}};
  for (const auto& [name, place] : places) {
    const SolidMesh mesh = Read(name);
    const auto held = ReadHeld(name, mesh.nodes.size());
    for (const auto& material : materials) {
      auto params = solids::Foam();
      params.material = material;
      params.options.gravity_O = {0, 0, -9.80665};
      const Contact press{.kind = Contact::Kind::kForce,
                          .p_O = place,
                          .width = 0.02,
                          .prescribed_O = directions.at(name)};
      FemModel linear(mesh, held, solids::Linear(params));
      Solution solution;
      Respond(linear, {press}, &solution);
      const auto f = Loads(mesh, press, material.density * params.options.gravity_O);
      EXPECT_LT(solids::Difference(solids::Displacement(linear, solution),
                                   IndependentLinear(mesh, held, material, f)),
                1e-8)
          << name << " " << linear.failure();

      params.options.residual = 1e-8;
      FemModel corotational(mesh, held, params);
      const auto r = Respond(corotational, {press}).front();
      EXPECT_TRUE(corotational.inverted() > 0 ? r.validity == Validity::kExtrapolated
                                              : r.validity != Validity::kFailed)
          << name << " " << material.young_modulus << " " << corotational.failure();
      EXPECT_GT(r.displacement_O.dot(press.prescribed_O), 0);
    }
  }
}

}  // namespace
}  // namespace palpate
