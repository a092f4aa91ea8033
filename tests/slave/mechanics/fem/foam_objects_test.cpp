// Paper B's foam objects: three meshes, three materials, weight and a press.
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/direct_solution.h"
#include "tests/slave/mechanics/fem/solids.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using solids::Respond;

const std::filesystem::path kFolder = SourcePath("/../shared/data/seed001_meshes");

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

// Reference: direct_solution.h, to the rounding of two direct solutions. The co-rotational answer
// exists too, and is flagged exactly where elements are inside out.
TEST(FoamObjects, AnswerUnderWeightAndAPressOfOneNewton) {
  if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "../shared/data is absent";
  const std::map<std::string, Vector3d> places{
      {"cube", {0.06, 0.03, 0.03}}, {"sponge", {0.06, 0.025, 0.02}}, {"bar", {0.18, 0.02, 0.04}}};
  const std::map<std::string, Vector3d> directions{
      {"cube", {-1, 0, 0}}, {"sponge", {0, 0, -1}}, {"bar", {0, 0, -1}}};
  const std::array<Material, 3> materials{{{3800, 0.15, 45}, {3200, 0.15, 30}, {3000, 0.15, 26}}};
  for (const auto& [name, place] : places) {
    const SolidMesh mesh = FoamMesh(name);
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
      const Body body{mesh, held, material.young_modulus, material.poisson_ratio};
      const Vector3d weight = material.density * params.options.gravity_O;
      EXPECT_LT(solids::Difference(solids::Displacement(linear, solution),
                                   SolveDirectly(body, {{press}}, false, weight).displacement_O),
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
