// Forces on paper A's block and embryo against the reference's constant-element and continuum
// values: k_bar = F / (E depth thickness).
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/scene/scene_loader.h"
#include "tests/reference/reference_file.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using reference::json;

constexpr int kMaxMesh = 540;  // elements

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

// Forces [N] on the elements under the problem's tool, for a displacement [m] of each.
using Vectors = std::vector<Eigen::Vector2d>;
Vectors ForcesOn(Bem2dModel& model, const BoundaryMesh& mesh, const std::vector<int>& elements,
                 const Vectors& displacements) {
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Eigen::Vector2d middle = mesh.elements[static_cast<std::size_t>(elements[i])].midpoint();
    contacts.push_back({.p_O = {middle.x(), middle.y(), 0}, .element = elements[i]});
    contacts.back().prescribed_O.head<2>() = displacements[i];
  }
  Vectors forces;
  for (const ContactResponse& response : contacts::Respond(model, contacts)) {
    EXPECT_EQ(response.validity, Validity::kValid);
    forces.emplace_back(response.force_O.head<2>());
  }
  return forces;
}

// The force along x for a displacement -depth along x, where the traction along y is zero: by
// superposition of displacements along y. A frictionless contact of one element would slide along
// the element.
double ForceWithoutTractionAlongY(Bem2dModel& model, const BoundaryMesh& mesh,
                                  const std::vector<int>& elements, double depth) {
  const auto size = static_cast<Eigen::Index>(elements.size());
  Eigen::MatrixXd along_x(size, size), along_y(size, size);
  for (Eigen::Index k = 0; k < size; ++k) {
    Vectors one(elements.size(), Eigen::Vector2d::Zero());
    one[static_cast<std::size_t>(k)].y() = depth;
    const Vectors forces = ForcesOn(model, mesh, elements, one);
    for (Eigen::Index i = 0; i < size; ++i) {
      along_x(i, k) = forces[static_cast<std::size_t>(i)].x();
      along_y(i, k) = forces[static_cast<std::size_t>(i)].y();
    }
  }
  const Vectors pressed =
      ForcesOn(model, mesh, elements, Vectors(elements.size(), Eigen::Vector2d(-depth, 0)));
  Eigen::VectorXd x(size), y(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    x[i] = pressed[static_cast<std::size_t>(i)].x();
    y[i] = pressed[static_cast<std::size_t>(i)].y();
  }
  return (x - along_x * along_y.partialPivLu().solve(y)).sum();
}

// The reference prescribes whole elements, one by one. A contact with a width is a rigid tool that
// holds the parts of the elements under it.
double StiffnessBar(const json& c, int count) {
  const json& p = c.at("params");
  const bool block = p.contains("width_m");
  Problem problem = block ? BlockProblem(p, count) : DiscProblem(p, count);
  const std::string law = p.contains("contact") ? p.at("contact").get<std::string>()
                                                : p.at("patch_displacement").get<std::string>();
  const bool frictionless =
      law.find("t_y=0") != std::string::npos || law.find("frictionless") != std::string::npos;
  const bool slides = frictionless && block;
  // Cases that differ only by the place of the press share their Green's functions.
  static std::map<std::string, std::unique_ptr<Bem2dModel>> models;
  const double nu = p.at("poisson_ratio");
  const std::string key = (block ? "block" : "disc") + std::to_string(count) +
                          p.at("plane").get<std::string>() + std::to_string(nu) +
                          (slides ? "frictionless" : "bonded");
  auto& kept = models[key];
  if (!kept) {
    kept = std::make_unique<Bem2dModel>(
        ReferenceProblem{problem.mesh, problem.held, nu, reference::PlaneOf(p)},
        Bem2dModel::Params{.young_modulus = problem.youngs_modulus,
                           .thickness = problem.thickness,
                           .contact = slides ? ContactLaw::kFrictionless : ContactLaw::kBonded});
  }
  const BoundaryMesh& mesh = problem.mesh;
  const Eigen::Vector2d place = problem.contact.p_O.head<2>();
  const std::vector<int> elements =
      PatchElements(mesh, FindElement(mesh, place), place, problem.contact.width);
  double force = 0;
  if (frictionless && !slides) {
    force = -ForceWithoutTractionAlongY(*kept, mesh, elements, problem.depth);
  } else {
    const Vectors moved(elements.size(), problem.depth * problem.inward);
    for (const auto& on_element : ForcesOn(*kept, mesh, elements, moved)) {
      force += on_element.dot(problem.inward);
    }
  }
  return force / (problem.youngs_modulus * problem.depth * problem.thickness);
}

// Reference: b_block_embryo.json, the exact solution of the discrete equations (1e-6 in the same
// length unit).
TEST(BlockAndEmbryo, ConstantElementsReproduceTheDiscreteReference) {
  PALPATE_REFERENCE_OR_SKIP(file, "b_block_embryo.json");
  int compared = 0;
  for (const auto& c : file.at("cases")) {
    if (!c.contains("constant_element_bem")) continue;
    const std::string id = c.at("id");
    const double exact = c.at("expected").at("k_bar");
    for (const auto& [elements, value] :
         c.at("constant_element_bem").at("k_bar_by_element_count").items()) {
      const int count = std::stoi(elements);
      const double expected = value;
      if (count > kMaxMesh) continue;
      const double k_bar = StiffnessBar(c, count);
      EXPECT_NEAR(k_bar / expected, 1, 1e-6) << id << ", " << count << " elements";
      const double error = k_bar / exact - 1;
      // The error is at most the discretisation error of the reference's solver.
      EXPECT_LE(std::abs(error), std::abs(expected / exact - 1) + 1e-6) << id;
      ++compared;
    }
  }
  EXPECT_GE(compared, 69 * 2);
}

// Reference: block_width_study. In the plane the stiffness of a contact vanishes with its width:
// d(1 / k_bar) / d ln(1 / width) tends to 2 / pi (Flamant). Every patch is four elements wide, so
// that the discretisation adds nearly the same to each 1 / k_bar and hardly changes the slope (by
// 0.1 %). A rigid tool is narrower by a part of an element in the mesh, which the model corrects
// (element_places.h): the stiffness itself is within 0.2 %. Four whole elements would be 1 % to 3 %
// low.
TEST(BlockAndEmbryo, ANarrowerPatchIsSofterByTheLogarithmOfItsWidth) {
  PALPATE_REFERENCE_OR_SKIP(file, "b_block_embryo.json");
  const json study = reference::CaseOf(file, "block_width_study");
  const json& p = study.at("params");
  const double side = p.at("width_m");
  const json& table = study.at("expected").at("table");
  const json& slopes = study.at("expected").at("slope_of_inverse_k_per_ln_width");
  double previous = 0, slope = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double width = table.at(i).at("patch_width_m");
    const double exact = table.at(i).at("k_bar");
    const int count = 4 * static_cast<int>(std::lround(4 * side / width));
    const BoundaryMesh mesh = MeshRectangle(side, side, count);
    const auto held =
        reference::HeldWhere(mesh, [](const Eigen::Vector2d& m) { return m.y() < 1e-9; });
    Bem2dModel model({mesh, held, p.at("poisson_ratio"), reference::PlaneOf(p)},
                     {.young_modulus = 1, .thickness = 1});
    const ContactResponse response =
        contacts::Answer(model, contacts::Move({0.5 * side, side, 0}, {0, -1e-3 * side, 0}, width));
    const double k_bar = -response.force_O.y() / (1e-3 * side);
    if (i > 0) slope = (1 / k_bar - 1 / previous) / std::numbers::ln2;
    EXPECT_NEAR(k_bar / exact, 1, 0.002) << width;
    if (i > 0) {
      EXPECT_NEAR(slope / slopes.at(i - 1).get<double>(), 1, 0.002) << width;
    }
    previous = k_bar;
  }
  EXPECT_NEAR(slope / study.at("expected").at("slope_theory_2_over_pi").get<double>(), 1, 0.01);
}

// The shipped embryo with the elements of its scene, pressed over each of the reference's patches.
// Reference: the discs' continuum values, for arcs that move by the depth as a whole. The face of
// the pipette is flat, and the arc curves away from it: by reciprocity its force is that of the
// mean displacement under it, weighted with the pressure of a flat punch. That is the depth less
// a^2 / 4 R with half the width a (0.4 um for N60). Tolerance: the 5 % that are promised
// while the chorion is linear; beyond its range a force is flagged.
TEST(BlockAndEmbryo, TheShippedEmbryoFollowsTheDiscsInItsLinearRangeAndIsFlaggedBeyond) {
  PALPATE_REFERENCE_OR_SKIP(file, "b_block_embryo.json");
  int compared = 0;
  for (const auto& c : file.at("cases")) {
    const std::string id = c.at("id");
    const json& p = c.at("params");
    // The fixed arc and the tool's width are about those of the shipped embryo: 30 degrees, 40 um.
    if (!id.starts_with("disc_N60_") && !id.starts_with("disc_N100_")) continue;
    if (p.at("poisson_ratio") != 0.5) continue;
    Scene scene = LoadScene(SourcePath("/deploy/scenes/zebrafish-embryo.yaml"));
    const double radius = p.at("radius_m");
    scene.model.plane = reference::PlaneOf(p);
    scene.model.contact =
        id.ends_with("frictionless") ? ContactLaw::kFrictionless : ContactLaw::kBonded;
    const auto model = MakeModel(scene, MeshOutline(scene, std::nullopt));
    const double width = 2 * p.at("patch_half_angle_rad").get<double>() * radius;
    const double gap = width * width / (16 * radius);  // mean [m]
    double worst = 0;
    for (const double depth : {5e-6, 20e-6, 50e-6, 80e-6, 100e-6, 105e-6, 150e-6, 200e-6}) {
      const ContactResponse response =
          contacts::Answer(*model, contacts::Move({radius, 0, 0}, {-depth, 0, 0}, width));
      const double exact =
          c.at("expected").at("k_bar").get<double>() * 1.51e6 * (depth - gap) * 2 * radius;
      const bool is_linear = depth <= 100e-6;
      EXPECT_EQ(response.validity, is_linear ? Validity::kValid : Validity::kExtrapolated)
          << id << " " << depth;
      if (is_linear) worst = std::max(worst, std::abs(-response.force_O.x() / exact - 1));
    }
    EXPECT_LE(worst, 0.05) << id;
    ++compared;
  }
  EXPECT_EQ(compared, 8);
}

}  // namespace
}  // namespace palpate
