// Forces on paper A's block and embryo against the reference's constant-element and continuum
// values: k_bar = F / (E depth thickness).
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <string>

#include "tests/reference/reference_file.h"

namespace palpate {
namespace {

using reference::json;

constexpr int kLargestMesh = 540;  // elements

struct Problem {
  BoundaryMesh mesh;
  reference::Held held;
  Contact contact;
  double youngs_modulus = 0, thickness = 1, depth = 0;
  Eigen::Vector2d inward;
};

Problem BlockProblem(const json& p, int count) {
  Problem problem;
  const double width = p.at("width_m");
  const double height = p.at("height_m");
  problem.mesh = MeshRectangle(width, height, count);
  problem.held =
      reference::HeldWhere(problem.mesh, [](const Eigen::Vector2d& m) { return m.y() < 1e-9; });
  problem.youngs_modulus = p.at("youngs_modulus_Pa");
  problem.thickness = p.at("thickness_m");
  const double low = p.at("patch_lo_m");
  const double high = p.at("patch_hi_m");
  const double middle = 0.5 * (low + high);
  const bool top = p.at("indented_side") == "top";
  problem.contact.p_O =
      top ? Eigen::Vector3d(middle, height, 0) : Eigen::Vector3d(width, middle, 0);
  problem.contact.width = high - low;
  problem.inward = top ? Eigen::Vector2d(0, -1) : Eigen::Vector2d(-1, 0);
  problem.depth = 1e-3;
  return problem;
}

Problem DiscProblem(const json& p, int count) {
  Problem problem;
  const double radius = p.at("radius_m");
  problem.mesh = MeshDisc(radius, count);
  const double half = p.at("hold_arc_half_angle_rad");
  const double centre = p.at("hold_arc_centre_rad");
  problem.held = reference::HeldWhere(problem.mesh, [&](const Eigen::Vector2d& m) {
    return std::abs(std::remainder(std::atan2(m.y(), m.x()) - centre, 2 * std::numbers::pi)) <=
           half + 1e-9;
  });
  problem.youngs_modulus = p.at("youngs_modulus_Pa");
  problem.contact.p_O = {radius, 0, 0};
  problem.contact.width = 2 * p.at("patch_half_angle_rad").get<double>() * radius;
  problem.inward = {-1, 0};
  problem.depth = 1e-6;
  return problem;
}

double StiffnessBar(const json& c, int count) {
  const json& p = c.at("params");
  const bool block = p.contains("width_m");
  Problem problem = block ? BlockProblem(p, count) : DiscProblem(p, count);
  const std::string law = p.contains("contact") ? p.at("contact").get<std::string>()
                                                : p.at("patch_displacement").get<std::string>();
  const bool frictionless =
      law.find("t_y=0") != std::string::npos || law.find("frictionless") != std::string::npos;
  // Cases that differ by the place of the press alone share their Green's functions.
  static std::map<std::string, std::unique_ptr<Bem2dModel>> models;
  const double nu = p.at("poisson_ratio");
  const std::string key = (block ? "block" : "disc") + std::to_string(count) +
                          p.at("plane").get<std::string>() + std::to_string(nu) +
                          (frictionless ? "frictionless" : "bonded");
  auto& kept = models[key];
  if (!kept) {
    kept = std::make_unique<Bem2dModel>(
        ReferenceProblem{problem.mesh, problem.held, nu, reference::PlaneOf(p)},
        Bem2dModel::Params{
            .young_modulus = problem.youngs_modulus,
            .thickness = problem.thickness,
            .contact = frictionless ? ContactLaw::kFrictionless : ContactLaw::kBonded});
  }
  Bem2dModel& model = *kept;
  problem.contact.value_O.head<2>() = problem.depth * problem.inward;
  ContactResponse response;
  model.Respond({&problem.contact, 1}, {&response, 1});
  EXPECT_EQ(response.validity, Validity::kValid);
  return response.force_O.head<2>().dot(problem.inward) /
         (problem.youngs_modulus * problem.depth * problem.thickness);
}

// Reference: b_block_embryo.json, the discrete equations' own answer (1e-6 in the same length
// unit). The table shows the discretisation error against the continuum value and its order.
TEST(BlockAndEmbryo, ConstantElementsReproduceTheDiscreteReference) {
  PALPATE_REFERENCE_OR_SKIP(file, "b_block_embryo.json");
  std::printf("%-46s %8s %10s %9s %6s\n", "case", "elements", "k_bar", "error", "order");
  int compared = 0;
  for (const auto& c : file.at("cases")) {
    if (!c.contains("constant_element_bem")) continue;
    const std::string id = c.at("id");
    const double exact = c.at("expected").at("k_bar");
    std::map<int, double> table;
    for (const auto& [count, k_bar] :
         c.at("constant_element_bem").at("k_bar_by_element_count").items()) {
      table[std::stoi(count)] = k_bar;
    }
    double previous_error = 0;
    int previous_count = 0;
    for (const auto& [count, expected] : table) {
      if (count > kLargestMesh) continue;
      const double k_bar = StiffnessBar(c, count);
      EXPECT_NEAR(k_bar / expected, 1, 1e-6) << id << ", " << count << " elements";
      const double error = k_bar / exact - 1;
      // The discretisation error of the reference's own solver, and no more.
      EXPECT_LE(std::abs(error), std::abs(expected / exact - 1) + 1e-6) << id;
      const double order = previous_count == 0
                               ? 0
                               : std::log(previous_error / error) /
                                     std::log(static_cast<double>(count) / previous_count);
      std::printf("%-46s %8d %10.6f %8.3f%% %6.2f\n", id.c_str(), count, k_bar, 100 * error, order);
      previous_error = error;
      previous_count = count;
      ++compared;
    }
  }
  EXPECT_GE(compared, 69 * 2);
}

}  // namespace
}  // namespace palpate
