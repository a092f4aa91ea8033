// Tests errors and orders of convergence of solids against closed forms, beams and an independent
// code.
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/fem/solid/shape_functions.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/mesh_resolution.h"
#include "tests/slave/mechanics/solid/bodies.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;

using Field = std::function<Vector3d(const Vector3d&)>;

// Root mean square over the volume of the displacement minus `exact`; the body is the unit cube.
double Error(const SolidModel& model, const Field& exact) {
  double sum = 0;
  const int n = model.mesh().nodes_per_element;
  for (int e = 0; e < model.mesh().element_count(); ++e) {
    const auto nodes = model.mesh().element(e);
    for (const auto& q : QuadratureOf(10)) {
      const ShapeValues shapes = ShapesAt(n, q.bary), corners = q.bary;
      Vector3d u = Vector3d::Zero(), p = Vector3d::Zero();
      for (int i = 0; i < n; ++i) {
        const int node = nodes[static_cast<std::size_t>(i)];
        u += shapes[i] * model.displacement(node);
        if (i < 4) p += corners[i] * model.mesh().nodes[static_cast<std::size_t>(node)];
      }
      sum += q.weight * GeometryOf(model.mesh().nodes, nodes).volume * (u - exact(p)).squaredNorm();
    }
  }
  return std::sqrt(sum);
}

// Radon's seven-point rule on a triangle, degree 5: barycentric point and weight.
std::vector<std::pair<Vector3d, double>> TriangleRule() {
  std::vector<std::pair<Vector3d, double>> rule{{Vector3d::Constant(1.0 / 3), 9.0 / 40}};
  for (const double sign : {-1.0, 1.0}) {
    const double a = (6 + sign * std::sqrt(15.0)) / 21;
    const double weight = (155 + sign * std::sqrt(15.0)) / 1200;
    for (int i = 0; i < 3; ++i) {
      Vector3d bary = Vector3d::Constant(a);
      bary[i] = 1 - 2 * a;
      rule.emplace_back(bary, weight);
    }
  }
  return rule;
}

// A field in equilibrium without body force on the unit cube: u = a grad(e^x sin(y) z), whose
// potential is harmonic, so div u = 0 and the stress 2 mu grad u has no divergence, whatever nu.
struct Harmonic {
  double a = 1e-3;
  [[nodiscard]] Vector3d u(const Vector3d& p) const {
    return a * std::exp(p.x()) *
           Vector3d(std::sin(p.y()) * p.z(), std::cos(p.y()) * p.z(), std::sin(p.y()));
  }
  // Traction on z = 1, divided by 2 mu.
  [[nodiscard]] Vector3d top(const Vector3d& p) const {
    return a * std::exp(p.x()) * Vector3d(std::sin(p.y()), std::cos(p.y()), 0);
  }
};

// The field's displacements on five faces and its tractions on the sixth, at every node.
std::vector<Contact> DriveBy(const Harmonic& field, const TetMesh& mesh, double mu) {
  std::map<int, Vector3d> moved, pushed;
  for (std::size_t t = 0; t < mesh.surface.triangles.size(); ++t) {
    const auto& face = mesh.faces[t];
    const bool quadratic = face[3] >= 0;
    const auto p = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(face[i])]; };
    const bool top = p(0).z() == 1 && p(1).z() == 1 && p(2).z() == 1;
    for (std::size_t i = 0; i < (quadratic ? 6u : 3u); ++i) {
      if (!top) moved[face[i]] = field.u(p(i));
    }
    if (!top) continue;
    const double area = Area(mesh.surface, static_cast<int>(t));
    for (const auto& [bary, weight] : TriangleRule()) {
      const Vector3d traction =
          2 * mu * field.top(bary[0] * p(0) + bary[1] * p(1) + bary[2] * p(2));
      for (int i = 0; i < 3; ++i) {
        const double shape = quadratic ? bary[i] * (2 * bary[i] - 1) : bary[i];
        const auto corner = static_cast<std::size_t>(i);
        pushed.try_emplace(face[corner], 0, 0, 0).first->second += weight * area * shape * traction;
        if (!quadratic) continue;
        const double middle = 4 * bary[i] * bary[(i + 1) % 3];
        pushed.try_emplace(face[3 + corner], 0, 0, 0).first->second +=
            weight * area * middle * traction;
      }
    }
  }
  std::vector<Contact> contacts;
  for (const auto& [node, u] : moved) {
    contacts.push_back(Move(mesh.nodes[static_cast<std::size_t>(node)], u));
  }
  for (const auto& [node, force] : pushed) {
    if (moved.contains(node)) continue;
    contacts.push_back(Push(mesh.nodes[static_cast<std::size_t>(node)], force));
  }
  return contacts;
}

double HarmonicError(Element element, double nu, int cells) {
  SolidModel::Params params{.options = {.element = element, .law = Law::kLinear},
                            .young_modulus = 1,
                            .poisson_ratio = nu};
  const SolidMesh mesh = MeshBox({1, 1, 1}, {cells, cells, cells});
  SolidModel model(mesh, Nothing(mesh), params);
  const Harmonic field;
  const auto contacts = DriveBy(field, model.mesh(), 0.5 / (1 + nu));
  std::vector<ContactResponse> responses(contacts.size());
  model.Respond(contacts, responses);
  const bool locks = element == Element::kTet4 && nu >= kLocksAtPoint;
  EXPECT_EQ(responses[0].validity, locks ? Validity::kExtrapolated : Validity::kValid)
      << model.failure();
  return Error(model, [&](const Vector3d& p) { return field.u(p); }) / field.a;
}

// Reference: the harmonic field. Textbook orders of the mean displacement error: 2 with four nodes,
// 3 with ten. On these coarse meshes the order is at most 0.3 lower.
TEST(ConvergenceOrder, IsTwoWithFourNodesAndThreeWithTen) {
  for (const auto& [element, nu] : {std::pair{Element::kTet4, 0.3},
                                    {Element::kTet4, 0.45},
                                    {Element::kTet10, 0.3},
                                    {Element::kTet10, 0.45},
                                    {Element::kTet10, 0.49}}) {
    const double order = std::log2(HarmonicError(element, nu, 4) / HarmonicError(element, nu, 8));
    EXPECT_GT(order, element == Element::kTet4 ? 1.7 : 2.7) << nu;
  }
}

// Reference: the harmonic field does not depend on nu, so neither should the error. A pure
// displacement formulation locks as nu -> 0.5; ten-node elements with a pressure do not, up to and
// including 0.5.
TEST(Incompressibility, DoesNotLockWithAnUnknownPressure) {
  const double first = HarmonicError(Element::kTet10, 0.3, 4);
  for (const double nu : {0.49, 0.499, 0.4999, 0.5}) {
    EXPECT_LT(HarmonicError(Element::kTet10, nu, 4), 3 * first) << nu;
  }
}

// Reference: a column between smooth walls under its own weight, exactly quadratic: u_z = -(rho g /
// 2 M) (2 H z - z^2), M = E (1 - nu) / ((1 + nu) (1 - 2 nu)), pressure unknown lambda div u =
// -lambda / M rho g (H - z). At nu = 0.5 there is no displacement and the pressure is hydrostatic.
// Ten-node elements represent these fields exactly: only rounding and the residual remain.
TEST(Incompressibility, CarriesHydrostaticPressure) {
  for (const double nu : {0.49, 0.4999, 0.5}) {
    SolidModel::Params params{
        .options = {.element = Element::kTet10, .law = Law::kLinear, .gravity_O = {0, 0, -10}},
        .young_modulus = 1e4,
        .poisson_ratio = nu,
        .density = 1000};
    const double H = 0.1;
    const SolidMesh mesh = MeshBox({H, H, H}, {2, 2, 3});
    auto held = Nothing(mesh);
    for (std::size_t i = 0; i < held.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const double p = mesh.nodes[i][c];
        held[i][static_cast<std::size_t>(c)] = p == 0 || (c < 2 && p > H * (1 - 1e-9));
      }
    }
    SolidModel model(mesh, held, params);
    model.Respond({}, {});
    ASSERT_TRUE(model.failure().empty()) << model.failure();
    const double M_inverse = (1 + nu) * (1 - 2 * nu) / (1e4 * (1 - nu));
    for (int i = 0; i < model.mesh().vertex_count; ++i) {
      const double z = H * model.mesh().nodes[static_cast<std::size_t>(i)].z();
      const Vector3d u(0, 0, -0.5 * 1e4 * M_inverse * (2 * H * z - z * z));
      EXPECT_LT((model.displacement(i) - u).norm(), 1e-9 * H) << "nu = " << nu;
      EXPECT_NEAR(model.pressure(i), -nu / (1 - nu) * 1e4 * (H - z), 1e-6 * 1e4 * H)
          << "nu = " << nu;
    }
  }
}

// Reference: d_solid3d, elastica_tip_load (Bisshopp and Drucker 1945): a slender beam under a dead
// load on its end, 2 % at L / h = 20, for both laws with rotations.
TEST(Cantilever, FollowsTheElastica) {
  PALPATE_CASE_OR_SKIP(reference, "d_solid3d.json", "elastica_tip_load");
  const double h = 0.05, EI = 1e6 * std::pow(h, 4) / 12;  // of a length of 1 m
  const SolidMesh mesh = MeshBox({1, h, h}, {20, 1, 1});
  const HeldNodes held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() == 0; });
  SolidModel::Params params{.options = {.element = Element::kTet10}, .young_modulus = 1e6};
  for (const Law law : {Law::kCorotational, Law::kNeoHookean}) {
    params.options.law = law;
    for (const auto& row : reference.at("expected")) {
      const double load = row.at("PL2_over_EI").get<double>();
      SolidModel model(mesh, held, params);
      const ContactResponse response =
          Answer(model, Push({1, h / 2, h / 2}, {0, 0, load * EI}, 2 * h));
      ASSERT_NE(response.validity, Validity::kFailed) << model.failure();
      const Vector3d& u = response.displacement_O;
      EXPECT_NEAR(1 + u.x(), row.at("x_tip_over_L").get<double>(), 0.02) << load;
      EXPECT_NEAR(u.z(), row.at("y_tip_over_L").get<double>(), 0.02) << load;
    }
  }
}

// Returns the upward displacement at the centre of the foam cube's top.
double TopUnder(const SolidModel::Params& params, const SolidMesh& mesh,
                const std::vector<Contact>& load) {
  SolidModel model(mesh, Bottom(mesh), params);
  std::vector<ContactResponse> responses(load.size());
  model.Respond(load, responses);
  EXPECT_TRUE(model.failure().empty()) << model.failure();
  return model.displacement(NodeAt(model, kCube, {0.03, 0.03, kCube})).z();
}

// Reference: h_calculix, the foam cube by quadratic bricks: 0.5 % under the patch, 0.2 % under its
// own weight, its tolerances.
TEST(FoamCube, AgreesWithQuadraticBricks) {
  PALPATE_CASE_OR_SKIP(patch, "h_calculix.json", "cube_linear_patch");
  PALPATE_CASE_OR_SKIP(weight, "h_calculix.json", "cube_linear_gravity");
  const SolidMesh mesh = MeshBox(Vector3d::Constant(kCube), {9, 9, 9});
  auto params = Foam(Element::kTet10, Law::kLinear);
  const double pressed = VectorOf(patch.at("expected").back().at("u_top_centre")).z();
  EXPECT_NEAR(TopUnder(params, mesh, SquareLoad(mesh, 1)) / pressed, 1, 0.005);
  params.options.gravity_O = {0, 0, -9.80665};
  const double sunk = VectorOf(weight.at("expected").back().at("u_top_centre")).z();
  EXPECT_NEAR(TopUnder(params, mesh, {}) / sunk, 1, 0.002);
}

}  // namespace
}  // namespace palpate
