// Every model at its extremes, one axis at a time and combined: the answer is accurate to a bound
// stated beforehand, or flagged, or refused with a reason. `--full` sweeps finer and larger.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/membrane/inflated_membrane.h"
#include "tests/stability/extremes/bodies.h"

namespace palpate::extremes {
namespace {

using Eigen::Vector3d;

bool full_sweep = false;

std::string Text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

std::vector<double> Fine(std::vector<double> quick, std::vector<double> full) {
  return full_sweep ? full : quick;
}

const std::vector<double> kLengths{1e-9, 1e-6, 1e-3, 1, 1e3};
const std::vector<double> kModuli{1, 1e3, 1e6, 1e9, 1e12};
const std::vector<double> kPoisson{-0.9, -0.5, 0, 0.3, 0.45, 0.49, 0.499, 0.4999, 0.5};
const std::vector<double> kAspects{1, 10, 100, 1e3, 1e4};

void CheckStretches(const Stretch& stretch, const std::string& axis, const std::string& value) {
  for (const Family& f : Volumes()) CheckVolumeStretch(f, stretch, axis, value);
  for (const Family& f : Outlines()) CheckOutlineStretch(f, stretch, axis, value);
}

// Reference: u = F L / (E A), see bodies.h, and dimensional analysis.
TEST(Extremes, LengthAndModulus) {
  for (const double length : kLengths) {
    for (const double E : Fine({1, 1e6, 1e12}, kModuli)) {
      CheckStretches({.length = length, .E = E}, "length, modulus",
                     Text(length) + " m, " + Text(E) + " Pa");
    }
  }
}

TEST(Extremes, PoissonRatio) {
  for (const double nu : kPoisson) CheckStretches({.nu = nu}, "nu", Text(nu));
}

TEST(Extremes, ElementAspect) {
  for (const double aspect : kAspects) {
    for (const double turned : {aspect, 1 / aspect}) {
      CheckStretches({.aspect = turned}, "aspect", Text(turned));
    }
  }
}

// Up to and beyond the load that inverts elements.
TEST(Extremes, Load) {
  for (const double strain : {1e-12, 1e-6, 1e-3, 0.05, 1.0, 10.0, 1e6, -0.05, -0.5, -1.0, -10.0}) {
    CheckStretches({.strain = strain}, "load / (E A)", Text(strain));
  }
}

TEST(Extremes, Size) {
  for (const double n : Fine({1, 3, 8}, {1, 2, 4, 8, 16, 32})) {
    const int cells = static_cast<int>(n);
    for (const Family& f : Volumes()) {
      if (f.is_quadratic() && cells > 16) continue;
      CheckVolumeStretch(f, {.cells = {cells, cells, cells}}, "tetrahedra", Text(6 * n * n * n));
    }
  }
  for (const double n : Fine({4, 40, 400}, {4, 10, 40, 100, 400, 1000})) {
    for (const Family& f : Outlines()) {
      CheckOutlineStretch(f, {.elements = static_cast<int>(n)}, "elements", Text(n));
    }
  }
}

// Different nodes of the free surface, spread over it.
std::vector<Vector3d> SpreadNodes(const SolidMesh& mesh, std::size_t count) {
  const SurfaceMesh skin = SurfaceOf(mesh);
  std::vector<char> touched(mesh.nodes.size(), 0);
  for (const auto& t : skin.triangles) {
    for (const int node : t) touched[static_cast<std::size_t>(node)] = 1;
  }
  std::vector<Vector3d> places;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    if (touched[i] != 0 && mesh.nodes[i].minCoeff() > 0) places.push_back(mesh.nodes[i]);
  }
  std::mt19937 random(1);
  std::ranges::shuffle(places, random);
  places.resize(std::min(count, places.size()));
  return places;
}

std::vector<Contact> RandomLoads(const std::vector<Vector3d>& places, double force) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> component(-force, force);
  std::vector<Contact> loads;
  for (const auto& p : places) {
    Contact load{Contact::Kind::kForce, p};
    load.prescribed_O = {component(random), component(random), component(random)};
    loads.push_back(load);
  }
  return loads;
}

// Reference: the inverse problem: if the displacements caused by loads are prescribed, they must
// give these loads. Bound: the residual of the answers times the condition of the capacitance
// matrix.
double ThereAndBack(DeformationModel& model, const std::vector<Contact>& loads, Validity* worst) {
  const auto moved = Query(model, loads, worst);
  std::vector<Contact> contacts = loads;
  double scale = 0, error = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].kind = Contact::Kind::kDisplacement;
    contacts[i].prescribed_O = moved[i].displacement_O;
    scale = std::max(scale, loads[i].prescribed_O.norm());
  }
  const auto forces = Query(model, contacts, worst);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    error = std::max(error, (forces[i].force_O - loads[i].prescribed_O).norm());
  }
  return error / scale;
}

TEST(Extremes, SimultaneousContacts) {
  for (const double count : Fine({1, 8, 64, 300}, {1, 2, 8, 32, 64, 128, 300, 500})) {
    for (const Family& f : Volumes()) {
      const int n = count > 100 ? 12 : 4;
      Stretch stretch{.cells = {n, n, n}};
      Scene scene = VolumeScene(f, stretch);
      scene.model.fem.residual = 1e-10;
      const ObjectMesh mesh = MeshObject(scene, std::nullopt);
      const auto places = SpreadNodes(std::get<SolidMesh>(mesh), static_cast<std::size_t>(count));
      const double force = 1e-6 * stretch.E * stretch.length * stretch.length;
      CheckBody(f, "contacts", Text(count), scene, mesh, 1e-4,
                [&](DeformationModel& model, Validity* worst) {
                  return ThereAndBack(model, RandomLoads(places, force), worst);
                });
    }
  }
}

// A contact on a supported node with zero displacement is accepted.
TEST(Extremes, HeldNodesStay) {
  for (const Family& f : Volumes()) {
    const Scene scene = VolumeScene(f, {});
    const Contact held{Contact::Kind::kDisplacement, {0, 0, 0}, -1, 0, {0, 0, 0}};
    CheckBody(f, "place", "held node stays", scene, MeshObject(scene, std::nullopt), 0,
              [&](DeformationModel& model, Validity* worst) {
                return Query(model, {held}, worst)[0].displacement_O.norm();
              });
  }
}

// Reference: the linear element's stiffness by hand: nodes 0 to 2 fixed, the apex pulled along z
// gives F = (lambda + 2 mu) / 6 u for the unit tetrahedron (reference d, rational stiffness).
TEST(Extremes, SingleElement) {
  const SolidMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  for (const Family& f : Volumes()) {
    if (f.is_quadratic()) continue;
    const double E = 1, nu = 0.25;
    Scene scene = VolumeScene(f, {.length = 1, .E = E, .nu = nu});
    scene.object.fixed = {Fixed{FixedNodes{{0, 1, 2}}, {true, true, true}}};
    const Contact pull{Contact::Kind::kDisplacement, {0, 0, 1}, -1, 0, {0, 0, 1e-6}};
    CheckBody(f, "single element", "unit", scene, mesh, 1e-5,
              [&](DeformationModel& model, Validity* worst) {
                const double force = Query(model, {pull}, worst)[0].force_O.z();
                return std::abs(force / (1e-6 * 0.2) - 1);
              });
  }
}

// Reference: energy. A body under a sudden load never moves beyond twice its static deflection, and
// implicit Euler only removes energy. With the smallest steps it has hardly moved.
TEST(Extremes, TimeStepDensityAndModulus) {
  for (const Family& f : Volumes()) {
    if (f.kind != "fem") continue;
    for (const double step : Fine({1e-6, 1e-3, 1}, {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1})) {
      for (const double density : Fine({1, 2e4}, {1, 45, 1e3, 2e4})) {
        for (const double E : Fine({1, 1e9}, {1, 3800, 1e6, 1e9, 1e12})) {
          const Stretch stretch{.E = E};
          Scene scene = VolumeScene(f, stretch);
          scene.object.material.density = density;
          const double L = stretch.length, strain = 1e-3;
          Contact pull{Contact::Kind::kForce, {L, L / 2, L / 2}};
          pull.width = 4 * L;
          pull.prescribed_O.x() = strain * E * L * L;
          const double at_rest = strain * L;
          scene.model.fem.time = FemOptions::Time::kDynamic;
          scene.model.fem.step = step;
          CheckBody(f, "step, density, modulus",
                    Text(step) + " s, " + Text(density) + " kg/m3, " + Text(E) + " Pa", scene,
                    MeshObject(scene, std::nullopt), 2.05,
                    [&](DeformationModel& model, Validity* w) {
                      double largest = 0;
                      for (int k = 0; k < 40; ++k) {
                        if (k == 20) pull.prescribed_O.setZero();
                        const auto r = Query(model, {pull}, w);
                        largest = std::max(largest, std::abs(r[0].displacement_O.x()));
                      }
                      return largest / at_rest;
                    });
        }
      }
    }
  }
}

// Reference: w = F a^2 / (16 pi D), point load at the centre, in the small-deflection limit.
void CheckPress(const Family& f, double radius, double thickness, double E, double nu,
                double w_over_t, const std::string& axis, const std::string& value) {
  const Scene scene = MembraneScene(f, radius, thickness, E, nu);
  const double D = E * std::pow(thickness, 3) / (12 * (1 - nu * nu));
  const double w = w_over_t * thickness;
  const double linear = w * 16 * std::numbers::pi * D / (radius * radius);
  // Stretching stiffens by about 0.45 (w/t)^2 at the point load (reference c,
  // linear_plate_validity).
  const double bound = f.bound + (f.kind == "plate" ? 0 : 0.6 * w_over_t * w_over_t);
  CheckBody(f, axis, value, scene, MeshObject(scene, std::nullopt), bound,
            [&](DeformationModel& model, Validity* worst) {
              const Contact press{Contact::Kind::kDisplacement, {0, 0, 0}, -1, 0, {0, 0, -w}};
              return std::abs(-Query(model, {press}, worst)[0].force_O.z() / linear - 1);
            });
}

TEST(Extremes, Membranes) {
  for (const Family& f : Membranes()) {
    for (const double radius : kLengths) {
      for (const double E : Fine({1, 1e6, 1e12}, kModuli)) {
        CheckPress(f, radius, 0.02 * radius, E, 0.45, 1e-3, "length, modulus",
                   Text(radius) + " m, " + Text(E) + " Pa");
      }
    }
    for (const double nu : kPoisson) CheckPress(f, 0.039, 1e-3, 1e6, nu, 1e-3, "nu", Text(nu));
    for (const double slender : {5.0, 10.0, 100.0, 1e3, 1e4, 1e5}) {
      CheckPress(f, 0.039, 0.039 / slender, 1e6, 0.45, 1e-3, "radius / thickness", Text(slender));
    }
    for (const double w : {1e-9, 1e-3, 0.1, 0.5}) {
      CheckPress(f, 0.039, 1e-3, 1e6, 0.45, w, "w / t", Text(w));
    }
  }
}

TEST(Extremes, MembraneContacts) {
  for (const Family& f : Membranes()) {
    for (const double count : Fine({1, 4, 16, 64}, {1, 4, 16, 64, 200, 500})) {
      const double a = 0.039;
      const Scene scene = MembraneScene(f, a, 1e-3, 27.2e6, 0.45);
      std::vector<Vector3d> places;  // Vogel's spiral, with nearly uniform distances
      for (int i = 0; i < static_cast<int>(count); ++i) {
        const double r = 0.9 * a * std::sqrt((i + 0.5) / count), angle = 2.399963 * i;
        places.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
      }
      CheckBody(f, "contacts", Text(count), scene, MeshObject(scene, std::nullopt), 1e-5,
                [&](DeformationModel& model, Validity* worst) {
                  auto loads = RandomLoads(places, 1e-4 / count);
                  for (auto& load : loads) load.prescribed_O.head<2>().setZero();
                  return ThereAndBack(model, loads, worst);
                });
    }
  }
}

// The skin without bending stiffness, under a pressure. References: a flat disc bulges by
// q a^2 / (4 T) at its centre, with any modulus, since it stays flat to first order (bound: that of
// linear triangles, inflated_membrane_test); a dome moves by q a^2 / T times a function of the
// ratios E h / T and nu, the same at every length and tension.
double RiseAtTop(const MembraneShape& shape, const InflatedMembrane::Params& params,
                 double pressure) {
  const InflatedMembrane membrane(shape, params);
  std::vector<Vector3d> forces, moved;
  for (std::size_t i = 0; i < membrane.areas().size(); ++i) {
    forces.emplace_back(pressure * membrane.areas()[i] * membrane.normals()[i]);
  }
  membrane.Displace(forces, &moved);
  std::size_t top = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (!moved[i].allFinite()) throw std::runtime_error("a number is not finite");
    const auto& nodes = membrane.surface().nodes;
    if (nodes[i].z() - nodes[i].head<2>().norm() > nodes[top].z() - nodes[top].head<2>().norm()) {
      top = i;
    }
  }
  return moved[top].z();
}

TEST(Extremes, Skins) {
  constexpr int kRings = 24;
  for (const double a : kLengths) {
    for (const double T : {1e-9, 1.0, 1e6}) {
      for (const double modulus : {0.0, 1.0, 1e3}) {  // E h / T
        for (const double nu : Fine({-0.9, 0.3, 0.5}, kPoisson)) {
          const double q = 1e-3 * T / a;
          const auto rise = [&](const MembraneShape& shape, double tension, double pressure) {
            return RiseAtTop(
                shape, {.modulus = modulus * tension, .poisson_ratio = nu, .tension = tension},
                pressure);
          };
          const std::string cell =
              Text(a) + " m, " + Text(T) + " N/m, E h / T " + Text(modulus) + ", nu " + Text(nu);
          CheckCell("membrane", "flat, " + cell, 4e-3, [&](Validity*) {
            const double expected = q * a * a / (4 * T);
            return std::abs(rise(MeshFlatMembrane(a, kRings), T, q) / expected - 1);
          });
          const auto dome = [](double radius) {
            Ellipsoid sphere;
            sphere.semi_axes *= radius;
            return MeshDomedMembrane(sphere, {0, 0, 1}, 0.5 * radius, 8);
          };
          CheckCell("membrane", "dome, " + cell, 1e-8, [&](Validity*) {
            const double unit = rise(dome(1), 1, 1e-3);
            return std::abs(rise(dome(a), T, q) / (unit * a) - 1);
          });
        }
      }
    }
  }
}

// All parameters at once, drawn at random with a fixed seed.
TEST(Extremes, Combinations) {
  std::mt19937 random(5);
  const auto pick = [&](const std::vector<double>& from) {
    return from[std::uniform_int_distribution<std::size_t>(0, from.size() - 1)(random)];
  };
  const int draws = full_sweep ? 200 : 20;
  for (int i = 0; i < draws; ++i) {
    const int n = static_cast<int>(pick({1, 2, 3}));
    Stretch s{.length = pick(kLengths),
              .E = pick(kModuli),
              .nu = pick(kPoisson),
              .aspect = pick({1e-4, 1e-2, 0.3, 1, 3, 1e2, 1e4}),
              .strain = pick({1e-9, 1e-6, 1e-3, 0.3, -0.3, 3, -3}),
              .cells = {n, 1 + i % 3, n},
              .elements = static_cast<int>(pick({8, 40, 100}))};
    const std::string value = Text(s.length) + " m, " + Text(s.E) + " Pa, nu " + Text(s.nu) +
                              ", aspect " + Text(s.aspect) + ", strain " + Text(s.strain) +
                              ", cells " + Text(n);
    CheckStretches(s, "combined", value);
  }
}

}  // namespace
}  // namespace palpate::extremes

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  palpate::extremes::full_sweep = argc > 1 && std::string(argv[1]) == "--full";
  const int result = RUN_ALL_TESTS();
  std::map<std::string, int> total;
  for (const auto& [family, outcomes] : palpate::extremes::Outcomes()) {
    std::printf("%s:", family.c_str());
    for (const auto& [outcome, count] : outcomes) {
      std::printf(" %d %s", count, outcome.c_str());
      total[outcome] += count;
    }
    std::printf("\n");
  }
  for (const auto& [outcome, count] : total) std::printf("%d cells %s\n", count, outcome.c_str());
  return result;
}
