// Models of linear elements against solutions of the same elements by another formulation. A model
// joins by one line in Cases().
#include "tests/slave/mechanics/direct_solution.h"

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slave/mechanics/fem/fem_model.h"
#include "slave/mechanics/fem/green/fem_green_model.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mesh/index.h"
#include "tests/slave/mechanics/contacts.h"

namespace palpate {
namespace {

using contacts::Move;
using contacts::Push;
using Eigen::Vector3d;
using Element = FemOptions::Element;
using Model = std::unique_ptr<DeformationModel>;
using Contacts = std::vector<Contact>;

constexpr double kResidual = 1e-12;
constexpr double kRange = 10;

Model LinearFem(const Body& body) {
  FemModel::Params params{
      .material = {.young_modulus = body.E, .poisson_ratio = body.nu, .density = 1},
      .options = {.law = FemOptions::Law::kLinear, .residual = kResidual},
      .range = kRange};
  return std::make_unique<FemModel>(body.mesh, body.held, params);
}

Model LinearSolid(const Body& body, Element element) {
  SolidModel::Params params{
      .options = {.element = element, .law = FemOptions::Law::kLinear, .residual = kResidual},
      .young_modulus = body.E,
      .poisson_ratio = body.nu,
      .range = kRange};
  return std::make_unique<SolidModel>(body.mesh, body.held, params);
}

Model LinearGreen(const Body& body, Element element, ContactLaw law = ContactLaw::kBonded) {
  const FemGreenModel::Options options{.element = element, .contact = law, .range = kRange};
  return std::make_unique<FemGreenModel>(body.mesh, body.held, body.E, body.nu, options);
}

struct Case {
  std::string name;
  std::function<Model(const Body&)> make;
  std::function<DirectAnswer(const Body&, const Contacts&)> solve;
  double nu = 0.3;
  bool frictionless = false;
  bool has_ten_nodes = false;
  bool touches = false;  // a disc that moves touches the surface where it reaches it
};
void PrintTo(const Case& tested, std::ostream* out) {
  *out << tested.name;
}

DirectAnswer Bonded(const Body& body, const Contacts& contacts) {
  return SolveDirectly(body, contacts, false, false);
}
// Of models that hold whole nodes under a flat tool.
DirectAnswer BondedWhole(const Body& body, const Contacts& contacts) {
  return SolveDirectly(body, contacts, false, true);
}

// SolidModel solves for all nodes of the body, in quadratic elements with their pressure.
DirectAnswer WholeBody(const Body& body, const Contacts& contacts) {
  const Model model = LinearSolid(body, Element::kTet10);
  Solution solution;
  model->Solve(contacts, &solution);
  DirectAnswer answer;
  for (const ContactResponse& response : solution.responses()) {
    answer.force_O.push_back(response.force_O);
    answer.mean_O.push_back(response.displacement_O);
  }
  model->Displacements(solution, &answer.displacement_O);
  return answer;
}

std::vector<Case> Cases() {
  std::vector<Case> cases{
      {.name = "fem", .make = LinearFem, .solve = Bonded, .touches = true},
      {"solid", [](const Body& body) { return LinearSolid(body, Element::kTet4); }, BondedWhole},
      {"green", [](const Body& body) { return LinearGreen(body, Element::kTet4); }, Bonded},
      {.name = "green_frictionless",
       .make =
           [](const Body& b) { return LinearGreen(b, Element::kTet4, ContactLaw::kFrictionless); },
       .solve = [](const Body& b, const Contacts& c) { return SolveDirectly(b, c, true, false); },
       .frictionless = true}};
  for (const double nu : {0.3, 0.49, 0.499, 0.5}) {
    const std::string name = "green_ten_nodes_" + std::to_string(static_cast<int>(1000 * nu));
    const auto make = [](const Body& body) { return LinearGreen(body, Element::kTet10); };
    cases.push_back({name, make, WholeBody, nu, false, true});
  }
  return cases;
}

// Nodes, points inside triangles and discs far from the support, on every side; several kinds
// together, as wide as the meshes follow.
Contacts Mixed(const Body& body) {
  const SurfaceMesh surface = SurfaceOf(body.mesh);
  const double side = Diagonal(body.mesh.nodes);
  std::vector<int> far;  // triangles far from each other and from the supports
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    bool apart = true;
    for (std::size_t n = 0; n < body.held.size(); ++n) {
      const bool near = (Centroid(surface, t) - body.mesh.nodes[n]).norm() < 0.2 * side;
      apart = apart && !(near && body.held[n][0]);
    }
    for (const int other : far) {
      apart = apart && (Centroid(surface, t) - Centroid(surface, other)).norm() > 0.25 * side;
    }
    if (apart) far.push_back(t);
  }
  const auto node = [&](std::size_t k) {
    return surface.nodes[Index(surface.triangles[Index(far.at(k))][0])];
  };
  // A tool that does not press is glued to all its nodes, as those of the reference.
  const Vector3d n = Normal(surface, far.at(4)), along = n.unitOrthogonal();
  const Vector3d pull = side * (0.003 * n + 0.01 * along);
  return {Move(node(0), {0.01 * side, -0.005 * side, 0.004 * side}),
          Push(Centroid(surface, far.at(1)), {0.02, 0.01, -0.03}, 0.2 * side),
          Move(0.9 * Centroid(surface, far.at(2)) + 0.1 * node(2), {0, 0.004 * side, -0.01 * side}),
          Push(node(3), {-0.01, 0.02, 0.005}), Move(node(4), pull, 0.25 * side)};
}

// Contacts at corners and midpoints of edges, and loads on the box.
Contacts OnTenNodes() {
  return {Move({0.06, 0.05, 0.04}, {1e-4, -2e-4, -3e-4}),
          Move({0, 0.05 / 6, 0.04}, {0, 1e-4, -2e-4}), Move({0.04, 0.018, 0.04}, {1e-4, 0, -5e-4}),
          Push({0.015, 0.035, 0.04}, {0.02, 0.01, -0.05}, 0.02),
          Push({0.06, 0, 0.04}, {0, 0.01, 0})};
}

double Largest(const std::vector<Vector3d>& vectors) {
  double largest = 0;
  for (const Vector3d& v : vectors) largest = std::max(largest, v.norm());
  return largest;
}

bool MayShare(const Contact& a, const Contact& b) {
  const double width = std::max(a.width, b.width);
  return width > 0 && (a.p_O - b.p_O).norm() < 5 * width;
}

// Condition numbers are below 1e6, so a tolerance of 1e-8 has a margin of two digits. `free`: 1 for
// the components of forces that are compared.
void ExpectSame(DeformationModel& model, const Contacts& contacts, const DirectAnswer& expected,
                const Vector3d& free = {1, 1, 1}) {
  constexpr double kTolerance = 1e-8;
  Solution solution;
  model.Solve(contacts, &solution);
  const double force = Largest(expected.force_O), moved = Largest(expected.mean_O);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactResponse& is = solution.responses()[i];
    ASSERT_NE(is.validity, Validity::kFailed) << "contact " << i << ": " << model.failure();
    if (contacts[i].kind == Contact::Kind::kDisplacement) {
      // A node of a disc, which may be a wider one, that another contact moves counts for either:
      // of such contacts only the field is compared.
      const bool shares = std::ranges::any_of(contacts, [&](const Contact& other) {
        return &other != &contacts[i] && MayShare(contacts[i], other);
      });
      if (shares) continue;
      // The force of these elements, without the correction for the mesh.
      const Vector3d off = free.cwiseProduct(is.force_O / is.mesh_factor - expected.force_O[i]);
      EXPECT_LT(off.norm(), kTolerance * force) << "contact " << i;
    } else {
      EXPECT_LT((is.displacement_O - expected.mean_O[i]).norm(), kTolerance * moved) << i;
    }
  }
  std::vector<Vector3d> field;
  model.Displacements(solution, &field);
  ASSERT_EQ(field.size(), expected.displacement_O.size());
  for (std::size_t n = 0; n < field.size(); ++n) {
    EXPECT_LT((field[n] - expected.displacement_O[n]).norm(),
              kTolerance * Largest(expected.displacement_O))
        << "node " << n;
  }
}

class DirectSolution : public testing::TestWithParam<std::tuple<Case, std::string>> {
 protected:
  void SetUp() override {
    const std::string& name = std::get<1>(GetParam());
    if (name == "box") {
      // Finer with four nodes: fem-green widens tools of five nodes or fewer.
      const std::array<int, 3> cells =
          case_.has_ten_nodes ? std::array{4, 3, 3} : std::array{8, 6, 6};
      body_ = ShakenBox(cells, 5e4, case_.nu);
      return;
    }
    if (case_.has_ten_nodes) GTEST_SKIP() << "the box is enough";
    const SolidMesh mesh = FoamMesh(name);
    if (mesh.nodes.empty()) GTEST_SKIP() << "../shared is absent";
    body_ = Standing(mesh, 0, 3800, 0.15);
  }
  const Case case_ = std::get<0>(GetParam());
  Body body_;
};

// Each kind of contact alone, then all together.
TEST_P(DirectSolution, ContactsOfAllKindsGiveItsForcesAndField) {
  const Model model = case_.make(body_);
  Contacts all = case_.has_ten_nodes ? OnTenNodes() : Mixed(body_);
  // On the box a wider disc would reach what the support holds.
  if (std::get<1>(GetParam()) == "box" && !case_.has_ten_nodes) all.back().width *= 0.8;
  if (case_.frictionless) all.erase(all.begin() + 2);  // no node's normal between nodes
  const auto is_tool = [](const Contact& contact) {
    return contact.kind == Contact::Kind::kDisplacement && contact.width > 0;
  };
  if (case_.touches) std::erase_if(all, is_tool);
  for (std::size_t i = 0; i <= all.size(); ++i) {
    const Contacts contacts = i < all.size() ? Contacts{all[i]} : all;
    ExpectSame(*model, contacts, case_.solve(body_, contacts));
  }
}

// A side is fixed in its normal direction only; a contact there prescribes the free components. The
// distribution of the normal force between support and contact is not determined.
TEST_P(DirectSolution, ASideThatIsFixedInOneComponentSlides) {
  for (std::size_t n = 0; n < body_.held.size(); ++n) {
    if (body_.mesh.nodes[n].y() == 0) body_.held[n][1] = true;
  }
  if (std::get<1>(GetParam()) != "box" || case_.frictionless) GTEST_SKIP() << "the box is enough";
  const Model model = case_.make(body_);
  const Contacts contacts{Move({0.03, 0, 0.04}, {1e-4, 0, -2e-4}),
                          Push({0.06, 0.03, 0.04}, {0.02, 0.01, 0})};
  ExpectSame(*model, contacts, case_.solve(body_, contacts), {1, 0, 1});
}

INSTANTIATE_TEST_SUITE_P(Models, DirectSolution,
                         testing::Combine(testing::ValuesIn(Cases()),
                                          testing::Values("box", "cube", "bar", "sponge")),
                         [](const auto& tested) {
                           return std::get<0>(tested.param).name + "_" + std::get<1>(tested.param);
                         });

}  // namespace
}  // namespace palpate
