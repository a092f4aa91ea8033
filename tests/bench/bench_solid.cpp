// Solids of ten- and four-node tetrahedra: cost of one static answer against size, error beside
// time. One thread, CPU time. Counters: `dof`; `error`, relative, of the foam cube's mean depth
// against Richardson's limit of ten nodes (its own error 0.3 %); `steps` of Newton's method;
// `ratio`, the time over that of a dense product of 768 x 768 matrices measured in the same run.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/bench/timing.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Element = FemOptions::Element;
using Law = FemOptions::Law;

constexpr double kCube = 0.06;   // [m]
constexpr double kForce = 0.25;  // [N]

// A quarter of the foam cube, pressed on the square at the centre of its top.
struct Cube {
  std::unique_ptr<SolidModel> model;
  std::vector<Contact> load;
  std::vector<ContactResponse> responses;

  Cube(Element element, Law law, int cells, double nu) {
    const SolidMesh mesh = MeshBox({kCube / 2, kCube / 2, kCube}, {cells, cells, 2 * cells});
    HeldNodes held;
    for (const auto& p : mesh.nodes) {
      held.push_back({p.z() == 0 || p.x() == 0, p.z() == 0 || p.y() == 0, p.z() == 0});
    }
    SolidModel::Params params;
    params.options.element = element;
    params.options.law = law;
    params.young_modulus = 3800;
    params.poisson_ratio = nu;
    params.range = 1;
    model = std::make_unique<SolidModel>(mesh, held, params);
    const SurfaceMesh& surface = model->mesh().surface;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
      const Vector3d centroid = kCube * Centroid(surface, t);
      if (centroid.z() < kCube * (1 - 1e-9) || centroid.x() > kCube / 6 ||
          centroid.y() > kCube / 6) {
        continue;
      }
      Contact contact;
      contact.kind = Contact::Kind::kForce;
      contact.element = t;
      contact.p_O = centroid;
      contact.width = 1e-9 * kCube;
      load.push_back(contact);
    }
    for (auto& contact : load) {
      contact.prescribed_O = Vector3d(0, 0, -kForce / 4) / static_cast<double>(load.size());
    }
    responses.resize(load.size());
  }

  double Depth() {
    model->Respond(load, responses);
    double depth = 0;
    for (const auto& r : responses) depth -= r.displacement_O.z();
    return depth / static_cast<double>(responses.size());
  }
};

// Limit of the depth from ten nodes on two meshes, by the order 2 that refinement shows.
double Limit(Law law, double nu) {
  static std::map<std::pair<int, double>, double> limits;
  auto& limit = limits[{static_cast<int>(law), nu}];
  if (limit == 0) {
    limit = (4 * Cube(Element::kTet10, law, 6, nu).Depth() -
             Cube(Element::kTet10, law, 3, nu).Depth()) /
            3;
  }
  return limit;
}

void StaticAnswer(benchmark::State& state, Element element, Law law, double nu) {
  Cube cube(element, law, static_cast<int>(state.range(0)), nu);
  const double limit = Limit(law, nu);
  double depth = cube.Depth(), spent = 0;
  for (auto _ : state) {
    cube.model->Reset();
    const double start = CpuSeconds();
    depth = cube.Depth();
    spent += CpuSeconds() - start;
  }
  state.counters["dof"] = static_cast<double>(cube.model->info().dof);
  state.counters["error"] = std::abs(depth / limit - 1);
  state.counters["steps"] = cube.model->newton_steps();
  state.counters["ratio"] = spent / static_cast<double>(state.iterations()) / ProductSeconds();
}

#define PALPATE_STATIC_ANSWER(name, ...) \
  BENCHMARK_CAPTURE(StaticAnswer, name, __VA_ARGS__)->Arg(3)->Arg(6)->Unit(benchmark::kMillisecond)
PALPATE_STATIC_ANSWER(tet4_linear, Element::kTet4, Law::kLinear, 0.15)->Arg(12);
PALPATE_STATIC_ANSWER(tet10_linear, Element::kTet10, Law::kLinear, 0.15);
PALPATE_STATIC_ANSWER(tet10_mixed_linear, Element::kTet10, Law::kLinear, 0.4999);
PALPATE_STATIC_ANSWER(tet4_neo, Element::kTet4, Law::kNeoHookean, 0.15)->Arg(9);
PALPATE_STATIC_ANSWER(tet10_neo, Element::kTet10, Law::kNeoHookean, 0.15);
PALPATE_STATIC_ANSWER(tet10_mixed_neo, Element::kTet10, Law::kNeoHookean, 0.499);
PALPATE_STATIC_ANSWER(tet10_corotational, Element::kTet10, Law::kCorotational, 0.15);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
