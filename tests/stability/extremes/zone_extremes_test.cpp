// Presses of `fem-zone` at its extremes: valid answers are those of the full model of the same mesh
// within the bound that they state.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/mesh_resolution.h"
#include "tests/stability/extremes/bodies.h"

namespace palpate::extremes {
namespace {

using Eigen::Vector3d;

// Green's functions are kept in single precision, and the full model stops at 1e-9 of its load: the
// least that an answer may be off, of its force [-].
constexpr double kRounding = 1e-5;

std::string Text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

// A slab on a rigid base, twice as wide as high, and discs of three cells on its top.
struct Slab {
  double length = 0.08;  // edge along x and y [m]
  double E = 5e3, nu = 0.4;
  int cells = 10;  // along x and y

  [[nodiscard]] double disc() const { return 3.4 * length / cells; }
  // On the top at shares of its edges, moved by `depth` discs downwards and half of it sideways.
  [[nodiscard]] Contact Press(double x, double y, double depth) const {
    Contact press;
    press.p_O = {x * length, y * length, 0.5 * length};
    press.width = disc();
    press.prescribed_O = Vector3d(0.5, 0, -1) * depth * disc();
    return press;
  }
  [[nodiscard]] Scene SceneOf(const std::string& kind) const {
    Scene scene;
    scene.name = kind;
    scene.object.material = {.young_modulus = E, .poisson_ratio = nu, .density = 1000};
    scene.object.geometry =
        BoxGeometry{{length, length, 0.5 * length}, {cells, cells, std::max(1, cells / 2)}};
    scene.object.fixed = {Fixed{FixedPlane{2, 0}, {true, true, true}}};
    scene.model.kind = kind;
    scene.model.range = 10;
    scene.model.fem.residual = 1e-9;
    scene.model.fem.law = FemOptions::Law::kNeoHookean;
    return scene;
  }
};

// Largest error by what the answer states of itself.
double ErrorByBound(const std::vector<ContactResponse>& got,
                    const std::vector<ContactResponse>& expected) {
  double worst = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    const double error = (got[i].force_O - expected[i].force_O).norm();
    const double least = kRounding * expected[i].force_O.norm();
    worst = std::max(worst, error / (got[i].force_error + least));
  }
  return worst;
}

// The reference has the same mesh: a flag of the mesh excuses nothing.
bool IsVouchedFor(const ContactResponse& response) {
  return response.validity == Validity::kValid || response.doubt == kStiffInBending;
}

// Presses one after the other by the same model. The worst valid answer counts, where there is one.
void CheckPresses(const Slab& slab, const ObjectMesh& mesh,
                  const std::vector<std::vector<Contact>>& presses, const std::string& axis,
                  const std::string& value) {
  const Family family{"fem-zone press", "fem-zone", {}, 1};
  const auto full = MakeModel(slab.SceneOf("fem"), mesh);
  const auto ask = [&](DeformationModel& model, Validity* worst) {
    double error = 0;
    int valid = 0;
    for (const auto& contacts : presses) {
      Validity validity = Validity::kValid;
      std::vector<ContactResponse> got;
      try {
        got = Query(model, contacts, &validity);
      } catch (const std::invalid_argument&) {
        continue;  // refused with a reason
      }
      if (!std::ranges::all_of(got, IsVouchedFor)) continue;
      ++valid;
      std::vector<ContactResponse> expected(contacts.size());
      full->Reset();
      full->Respond(contacts, expected);
      for (const auto& response : expected) {
        if (response.validity == Validity::kFailed) throw std::runtime_error("no reference");
      }
      error = std::max(error, ErrorByBound(got, expected));
    }
    if (valid == 0) *worst = Validity::kExtrapolated;
    return error;
  };
  CheckBody(family, axis, value, slab.SceneOf("fem-zone"), mesh, family.bound, ask);
}

void CheckPresses(const Slab& slab, const std::vector<std::vector<Contact>>& presses,
                  const std::string& axis, const std::string& value) {
  CheckPresses(slab, MeshObject(slab.SceneOf("fem-zone"), std::nullopt), presses, axis, value);
}

TEST(ZoneExtremes, LengthAndModulus) {
  for (const auto& [length, E] : {std::pair{1e-9, 1e12}, {1e-6, 1.0}, {1.0, 1e6}, {1e3, 1e12}}) {
    const Slab slab{.length = length, .E = E};
    CheckPresses(slab, {{slab.Press(0.5, 0.5, 0.2)}}, "length, modulus",
                 Text(length) + " m, " + Text(E) + " Pa");
  }
}

// Where the contributions around a zone cancel, as near nu = 0, and where an estimate grows from
// one order to the next, as below, the bound is the hardest to keep.
TEST(ZoneExtremes, PoissonRatio) {
  for (const double nu : {-0.99, -0.3, 0.0, 0.2, 0.48, 0.489, 0.499}) {
    const Slab slab{.nu = nu};
    for (const double depth : {0.2, 0.4, -0.1}) {
      Contact straight = slab.Press(0.5, 0.5, depth);
      straight.prescribed_O.x() = 0;
      CheckPresses(slab, {{slab.Press(0.5, 0.5, depth)}, {straight}}, "nu, depth / width",
                   Text(nu) + ", " + Text(depth));
    }
  }
}

TEST(ZoneExtremes, Depth) {
  const Slab slab;
  for (const double depth : {1e-12, 1e-6, 0.05, 0.6, 1.0, 3.0, 1e3, -0.2, -2.0}) {
    CheckPresses(slab, {{slab.Press(0.5, 0.5, depth)}}, "depth / width", Text(depth));
  }
}

// A press that turns elements inside out, or finds no equilibrium, leaves no trap behind.
TEST(ZoneExtremes, InvertedStarts) {
  const Slab slab;
  for (const double depth : {0.7, 1.5, -3.0, 30.0}) {
    CheckPresses(slab,
                 {{slab.Press(0.5, 0.5, depth)},
                  {slab.Press(0.5, 0.5, 0.1)},
                  {slab.Press(0.5, 0.5, depth)},
                  {slab.Press(0.4, 0.5, 0.1)}},
                 "start at depth / width", Text(depth));
  }
}

// Nodes moved at random until some tetrahedra are hardly more than triangles.
TEST(ZoneExtremes, Slivers) {
  const Slab slab;
  for (const double least : {0.1, 1e-2, 1e-3}) {
    auto mesh = std::get<SolidMesh>(MeshObject(slab.SceneOf("fem-zone"), std::nullopt));
    const double cell = slab.length / slab.cells, volume = cell * cell * cell / 6;
    std::mt19937 random(6);
    std::uniform_real_distribution<double> shift(-cell, cell);
    const auto smallest = [&] {
      double found = volume;
      for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t)
        found = std::min(found, SignedVolume(mesh, t));
      return found;
    };
    for (std::size_t n = 0; n < mesh.nodes.size(); n += 7) {
      const Vector3d before = mesh.nodes[n];
      if (before.minCoeff() <= 0 || before.x() >= slab.length || before.y() >= slab.length ||
          before.z() >= 0.5 * slab.length) {
        continue;
      }
      Vector3d by(shift(random), shift(random), shift(random));
      for (int halvings = 0; halvings < 12; ++halvings, by *= 0.8) {
        mesh.nodes[n] = before + by;
        if (smallest() >= least * volume) break;
        mesh.nodes[n] = before;
      }
    }
    CheckPresses(slab, mesh, {{slab.Press(0.5, 0.5, 0.05)}, {slab.Press(0.5, 0.5, 0.2)}},
                 "least volume", Text(least));
  }
}

// A sphere that slides under friction on the slab.
Contact Push(const Slab& slab, const Vector3d& by) {
  return {.p_O = {0.5 * slab.length, 0.5 * slab.length, 0.5 * slab.length},
          .prescribed_O = by * slab.length};
}

Scene SphereOn(const Slab& slab) {
  Scene scene = slab.SceneOf("fem-zone");
  scene.tool = Tool{.shape = Tool::Shape::kRound, .width = 0.5 * slab.length};
  scene.tool->radius = 0.25 * slab.length;
  scene.model.contact = ContactLaw::kFriction;
  scene.model.friction = 0.4;
  return scene;
}

// Reference: dimensional analysis. Force by E and the length squared is the same at every scale.
TEST(ZoneExtremes, ToolsAtEveryScale) {
  const Family family{"fem-zone tool", "fem-zone", {}, 1e-4};
  Vector3d expected = Vector3d::Zero();
  for (const auto& [length, E] :
       {std::pair{0.08, 5e3}, {1e-9, 1e12}, {1e-6, 1.0}, {1.0, 1e6}, {1e3, 1e12}}) {
    const Slab slab{.length = length, .E = E};
    const Scene scene = SphereOn(slab);
    CheckBody(family, "length, modulus", Text(length) + " m, " + Text(E) + " Pa", scene,
              MeshObject(scene, std::nullopt), family.bound,
              [&](DeformationModel& model, Validity* worst) {
                Query(model, {Push(slab, {0, 0, -0.06})}, worst);
                const auto got = Query(model, {Push(slab, {0.05, 0.02, -0.06})}, worst);
                const Vector3d force = got[0].force_O / (E * length * length);
                if (expected.isZero(0)) expected = force;
                return (force - expected).norm() / expected.norm();
              });
  }
  EXPECT_LT(expected.z(), 0);
}

// Far aside, through the body, out of it, far away. Whatever came before, a small press afterwards
// is as it was at first: friction forgets a tool that has left.
TEST(ZoneExtremes, ToolsThatGoAstray) {
  const Slab slab;
  const Family family{"fem-zone tool", "fem-zone", {}, 1e-3};
  const Scene scene = SphereOn(slab);
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  for (const Vector3d& way : {Vector3d(0.7, 0, -0.05), Vector3d(0, 0, -0.6), Vector3d(0, 0, 2),
                              Vector3d(30, 0, 0), Vector3d(0, 0, -1e5)}) {
    CheckBody(family, "way / length", Text(way.x()) + ", " + Text(way.z()), scene, mesh,
              family.bound, [&](DeformationModel& model, Validity* worst) {
                const auto first = Query(model, {Push(slab, {0, 0, -0.05})}, worst);
                std::vector<ContactResponse> responses(1);
                const Contact astray = Push(slab, way);
                model.Respond({&astray, 1}, responses);
                if (!responses[0].force_O.allFinite()) throw std::runtime_error("not finite");
                Query(model, {Push(slab, {0, 0, 0.1})}, worst);
                const auto again = Query(model, {Push(slab, {0, 0, -0.05})}, worst);
                return (again[0].force_O - first[0].force_O).norm() / first[0].force_O.norm();
              });
  }
}

// Discs side by side on a grid, all pressed at once.
TEST(ZoneExtremes, SimultaneousDiscs) {
  for (const int side : {1, 2, 3}) {
    const Slab slab{.cells = 12};
    std::vector<Contact> contacts;
    for (int i = 0; i < side * side; ++i) {
      const double x = (0.5 + i % side) / side, y = (0.5 + i / side) / side;
      contacts.push_back(slab.Press(x, y, 0.05));
      contacts.back().width = 0.6 * slab.length / std::max(2, side);
    }
    CheckPresses(slab, {contacts}, "discs", std::to_string(side * side));
  }
}

}  // namespace
}  // namespace palpate::extremes
