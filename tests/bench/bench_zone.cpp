// Presses on neo-Hookean bodies by zones, against the full model of the same mesh. Discs of 3.4
// cells at random places are pressed by up to 30 % of their width, obliquely, in 60 updates. One
// thread, CPU time. Counters: `p50_us` and `p99_us` per update after the first of a press,
// `first_ms` that one, `condense_ms` of a new place, `full_ms` of the full model's press; of the
// last update: `error_p95` [%] and `degrees_p95` against the full model, `covered` [%] with an
// error within the bound, `bound_by_error` its median, `valid` [%], `contacts` that were compared.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/fem/zone/fem_zone_model.h"
#include "tests/bench/timing.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kModulus = 5000;  // [Pa]
constexpr int kUpdates = 60;

enum Shape { kSlab, kLiver, kDome, kInclusion, kBlock };

// u and v from -1 to 1, w from 0 to 1 [m].
Vector3d LiverPoint(double u, double v, double w) {  // as deploy/scenes/make_liver.py
  const double x = u * std::sqrt(1 - v * v / 4), y = v * std::sqrt(1 - u * u / 4);
  const double s = 1 - w * w / 10, height = 62 * (1 - (x * x + y * y) / 5) * (1 - x / 4);
  return 1e-3 * Vector3d(80 * s * x, 52 * s * (y + x * x / 10 - 0.05), w * height);
}
Vector3d DomePoint(double u, double v, double w) {
  const double x = u * std::sqrt(1 - v * v / 3), y = v * std::sqrt(1 - u * u / 3);
  return 0.04 * Vector3d(x, y, w * (1 - 0.3 * (x * x + y * y)));
}

// About `tets` tetrahedra, the underside fixed.
SolidMesh MeshOf(Shape shape, int tets) {
  const auto box = [&](const Vector3d& size, const Vector3d& cells) {
    const double scale = std::cbrt(tets / (6 * cells.prod()));
    const auto count = [&](int axis) { return static_cast<int>(std::lround(scale * cells[axis])); };
    return MeshBox(size, {count(0), count(1), count(2)});
  };
  if (shape == kLiver || shape == kDome) {
    SolidMesh mesh = box({2, 2, 1}, shape == kLiver ? Vector3d(36, 26, 18) : Vector3d(32, 32, 16));
    const auto point = shape == kLiver ? LiverPoint : DomePoint;
    for (Vector3d& p : mesh.nodes) p = point(p.x() - 1, p.y() - 1, p.z());
    return mesh;
  }
  if (shape == kBlock) return box({0.05, 0.05, 0.06}, {5, 5, 6});
  SolidMesh mesh = box({0.08, 0.08, 0.04}, {2, 2, 1});
  for (const auto& tet : mesh.tets) {
    Vector3d centroid = Vector3d::Zero();
    for (const int node : tet) centroid += mesh.nodes[static_cast<std::size_t>(node)] / 4;
    const bool stiff =
        shape == kInclusion && (centroid - Vector3d(0.04, 0.04, 0.02)).norm() < 0.012;
    mesh.modulus.push_back(stiff ? 5 : 1);
  }
  return mesh;
}

struct Bodies {
  SolidMesh mesh;
  HeldNodes held;
  SurfaceMesh surface;
  double width;  // of the discs [m]
  std::unique_ptr<FemZoneModel> zone;
  std::unique_ptr<SolidModel> full;

  Bodies(Shape shape, int tets, double nu) : mesh(MeshOf(shape, tets)), surface(SurfaceOf(mesh)) {
    double volume = 0;
    for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) volume += SignedVolume(mesh, t);
    width = 3.4 * std::cbrt(6 * volume / static_cast<double>(mesh.tets.size()));
    for (const Vector3d& p : mesh.nodes) {
      const bool bottom = p.z() < 1e-9;
      held.push_back({bottom, bottom, bottom});
    }
    zone = std::make_unique<FemZoneModel>(mesh, held, kModulus, nu, FemZoneModel::Options{});
    SolidParams params;
    params.options.law = FemOptions::Law::kNeoHookean;
    params.options.residual = 1e-9;  // far below the bounds of small forces beside large ones
    params.young_modulus = kModulus;
    params.poisson_ratio = nu;
    params.density = 1000;
    full = std::make_unique<SolidModel>(mesh, held, params);
  }
  [[nodiscard]] const Vector3d& Corner(std::size_t triangle, std::size_t corner) const {
    return mesh.nodes[static_cast<std::size_t>(surface.triangles[triangle][corner])];
  }
  [[nodiscard]] Vector3d AreaOf(std::size_t triangle) const {
    const Vector3d& p = Corner(triangle, 0);
    return (Corner(triangle, 1) - p).cross(Corner(triangle, 2) - p) / 2;
  }
  // No edge of the body, and nothing held.
  [[nodiscard]] bool IsOpen(const Vector3d& p_O, const Vector3d& normal) const {
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      if ((Corner(t, 0) - p_O).norm() > 0.7 * width) continue;
      const Vector3d area = AreaOf(t);
      if (area.dot(normal) < 0.8 * area.norm() || Corner(t, 0).z() < 1e-9) return false;
    }
    return true;
  }
};

// Apart by two and a half widths, where that many fit.
std::vector<Contact> RandomContacts(const Bodies& bodies, int count, std::mt19937* random) {
  std::vector<double> areas;
  for (std::size_t t = 0; t < bodies.surface.triangles.size(); ++t) {
    areas.push_back(bodies.AreaOf(t).norm());
  }
  std::discrete_distribution<std::size_t> triangle(areas.begin(), areas.end());
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Contact> contacts;
  for (int tries = 0; static_cast<int>(contacts.size()) < count && tries < 1000; ++tries) {
    const std::size_t t = triangle(*random);
    const double side = std::sqrt(unit(*random)), share = unit(*random);
    Contact contact;
    contact.width = bodies.width;
    contact.p_O = (1 - side) * bodies.Corner(t, 0) +
                  side * ((1 - share) * bodies.Corner(t, 1) + share * bodies.Corner(t, 2));
    const Vector3d normal = bodies.AreaOf(t).normalized();
    const double depth = bodies.width * 0.3 * unit(*random), tangential = unit(*random) - 0.5;
    const Vector3d along = normal.cross(Vector3d(unit(*random), unit(*random), unit(*random)));
    contact.prescribed_O = depth * (tangential * along.normalized() - normal);
    const bool clear = std::ranges::all_of(contacts, [&](const Contact& other) {
      return (other.p_O - contact.p_O).norm() > 2.5 * bodies.width;
    });
    if (clear && bodies.IsOpen(contact.p_O, normal)) contacts.push_back(contact);
  }
  return contacts;
}

struct Tally {
  std::vector<double> update, first, condense, full, error, angle, ratio;
  int valid = 0, covered = 0;
};

void Press(Bodies& bodies, const std::vector<Contact>& contacts, Tally* tally) {
  std::vector<ContactResponse> got(contacts.size()), expected(contacts.size());
  double start = CpuSeconds();
  bodies.zone->Prefetch(contacts);
  tally->condense.push_back((CpuSeconds() - start) / static_cast<double>(contacts.size()));
  std::vector<Contact> now = contacts;
  for (int k = 1; k <= kUpdates; ++k) {
    for (std::size_t i = 0; i < now.size(); ++i) {
      now[i].prescribed_O = k * contacts[i].prescribed_O / kUpdates;
    }
    start = CpuSeconds();
    bodies.zone->Respond(now, got);
    (k == 1 ? tally->first : tally->update).push_back(CpuSeconds() - start);
  }
  bodies.full->Reset();
  start = CpuSeconds();
  bodies.full->Respond(contacts, expected);
  tally->full.push_back(CpuSeconds() - start);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (expected[i].validity == Validity::kFailed || got[i].validity == Validity::kFailed) continue;
    const Vector3d &f = got[i].force_O, &truth = expected[i].force_O;
    const double error = (f - truth).norm();
    tally->error.push_back(error / truth.norm());
    tally->angle.push_back(std::atan2(f.cross(truth).norm(), f.dot(truth)));
    tally->ratio.push_back(got[i].force_error / error);
    tally->valid += got[i].validity == Validity::kValid ? 1 : 0;
    tally->covered += error <= got[i].force_error ? 1 : 0;
  }
}

// Arguments: shape, thousands of tetrahedra, contacts (0: 1 to 8), Poisson's ratio in percent.
void Presses(benchmark::State& state) {
  Bodies bodies(static_cast<Shape>(state.range(0)), 1000 * static_cast<int>(state.range(1)),
                0.01 * static_cast<double>(state.range(3)));
  std::mt19937 random(5);
  std::uniform_int_distribution<int> several(1, 8);
  Tally tally;
  for (auto _ : state) {
    const int count = static_cast<int>(state.range(2));
    Press(bodies, RandomContacts(bodies, count > 0 ? count : several(random), &random), &tally);
  }
  const double all = 0.01 * static_cast<double>(tally.error.size());
  state.counters["tets"] = static_cast<double>(bodies.mesh.tets.size());
  state.counters["contacts"] = static_cast<double>(tally.error.size());
  state.counters["p50_us"] = 1e6 * Quantile(tally.update, 0.5);
  state.counters["p99_us"] = 1e6 * Quantile(tally.update, 0.99);
  state.counters["first_ms"] = 1e3 * Quantile(tally.first, 0.5);
  state.counters["condense_ms"] = 1e3 * Quantile(tally.condense, 0.5);
  state.counters["full_ms"] = 1e3 * Quantile(tally.full, 0.5);
  state.counters["error_p95"] = 100 * Quantile(tally.error, 0.95);
  state.counters["degrees_p95"] = 57.2958 * Quantile(tally.angle, 0.95);
  state.counters["bound_by_error"] = Quantile(tally.ratio, 0.5);
  state.counters["covered"] = tally.covered / all;
  state.counters["valid"] = tally.valid / all;
}
BENCHMARK(Presses)
    ->ArgsProduct({{kSlab, kLiver, kDome, kInclusion, kBlock}, {20}, {0}, {40}})
    ->Args({kLiver, 20, 0, 45})
    ->Args({kSlab, 18, 1, 40})
    ->Args({kSlab, 18, 1, 45})
    ->Args({kSlab, 18, 3, 40})
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(Presses)
    ->ArgsProduct({{kLiver}, {70, 100}, {1, 0}, {45}})
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
