#include "tests/trade/truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "shared/mesh/files/vtu_writer.h"
#include "shared/mesh/surface_patch.h"
#include "slave/mechanics/make_model.h"
#include "slave/site/points/membrane/pressed_membrane.h"
#include "slave/study/study.h"

namespace palpate::trade {
namespace {

using Eigen::Vector3d;
using study::Press;
using study::PressSpec;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// --- membranes
double OnSolidMembrane(const Scene& scene, const PressSpec& question, const Press& press) {
  constexpr int kSteps = 6;
  site::PressedMembrane membrane(std::get<MembraneGeometry>(scene.object.geometry),
                                 scene.object.material, question.width, press.p_O.head<2>());
  for (int i = 1; i <= kSteps; ++i) {
    if (!membrane.Deepen(question.depth * i / kSteps)) return kUnknown;
  }
  return -membrane.press().rungs.back()->force;
}

// --- planar objects
std::vector<double> LimitOfBoundaryElements(const Scene& scene, const PressSpec& question) {
  study::StudySettings settings;
  settings.timing_s = 0;
  settings.limits.dense_dof = 2600;
  settings.limits.families = {"bem2d quadratic"};
  for (const Press& press : question.presses) settings.places.push_back(press.p_O);
  const study::StudyResult study = RunStudy(scene, settings, study::RealWorkshop());
  std::vector<double> forces;
  for (const study::Reference& reference : study.references.presses) {
    forces.push_back(reference.full.value);
  }
  return forces;
}

// --- volumes
using Edge = std::array<int, 2>;
constexpr std::array<Edge, 6> kEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

// Cuts edges that are longer than `allowed` at their middle into two, and all tetrahedra around
// them, the longest edges first; the object stays what it is.
void Refine(const std::function<double(const Vector3d&)>& allowed, SolidMesh* mesh) {
  for (bool more = true; more;) {
    more = false;
    std::map<Edge, std::vector<std::size_t>> around;
    std::vector<std::pair<double, Edge>> long_ones;
    for (std::size_t t = 0; t < mesh->tets.size(); ++t) {
      for (const auto& [i, j] : kEdges) {
        const auto& tet = mesh->tets[t];
        const auto [a, b] =
            std::minmax(tet[static_cast<std::size_t>(i)], tet[static_cast<std::size_t>(j)]);
        around[{a, b}].push_back(t);
      }
    }
    // An edge is too long, too, if a shorter one beside it is: cutting the longest keeps shapes.
    std::map<Edge, double> lengths;
    for (const auto& [edge, tets] : around) {
      const Vector3d &a = mesh->nodes[static_cast<std::size_t>(edge[0])],
                     &b = mesh->nodes[static_cast<std::size_t>(edge[1])];
      lengths[edge] = (b - a).norm();
    }
    std::map<Edge, bool> chosen;
    for (const auto& [edge, tets] : around) {
      const Vector3d middle = 0.5 * (mesh->nodes[static_cast<std::size_t>(edge[0])] +
                                     mesh->nodes[static_cast<std::size_t>(edge[1])]);
      if (lengths[edge] <= allowed(middle)) continue;
      for (const std::size_t t : tets) {
        Edge longest{};
        double length = 0;
        for (const auto& [i, j] : kEdges) {
          const auto& tet = mesh->tets[t];
          const auto [a, b] =
              std::minmax(tet[static_cast<std::size_t>(i)], tet[static_cast<std::size_t>(j)]);
          if (lengths[{a, b}] > length * (1 + 1e-9)) longest = {a, b}, length = lengths[longest];
        }
        if (!std::exchange(chosen[longest], true)) long_ones.emplace_back(-length, longest);
      }
    }
    std::ranges::sort(long_ones);
    std::vector<char> taken(mesh->tets.size(), 0);
    for (const auto& [length, edge] : long_ones) {
      const auto& tets = around[edge];
      if (std::ranges::any_of(tets, [&](std::size_t t) { return taken[t] != 0; })) continue;
      const int middle = static_cast<int>(mesh->nodes.size());
      mesh->nodes.push_back(0.5 * (mesh->nodes[static_cast<std::size_t>(edge[0])] +
                                   mesh->nodes[static_cast<std::size_t>(edge[1])]));
      for (const std::size_t t : tets) {
        taken[t] = 1;
        auto half = mesh->tets[t];
        std::ranges::replace(half, edge[0], middle);
        std::ranges::replace(mesh->tets[t], edge[1], middle);
        mesh->tets.push_back(half);
      }
      more = true;
    }
  }
}

// Edges under the tool at most `finest`, farther away in proportion to the distance.
SolidMesh GradedTo(const SolidMesh& coarse, const Press& press, double width, double finest) {
  SolidMesh mesh = coarse;
  Refine(
      [&](const Vector3d& p) {
        return std::max(finest, 0.7 * ((p - press.p_O).norm() - 0.55 * width));
      },
      &mesh);
  return mesh;
}

double ForceOf(DeformationModel* model, const SurfaceMesh& skin, const Press& press, double width,
               double depth) {
  const auto place = FindPlace(skin, press.p_O);
  if (!place) return kUnknown;
  const Contact contact{Contact::Kind::kDisplacement, press.p_O, place->triangle, width,
                        depth * press.inward_O};
  ContactResponse response;
  model->Respond({&contact, 1}, {&response, 1});
  return IsForceKnown(response.validity) ? press.inward_O.dot(response.force_O) : kUnknown;
}

double OnVolume(const Scene& scene, const PressSpec& question, const Press& press) {
  constexpr int kSteps = 4;
  const SolidMesh coarse = std::get<SolidMesh>(MeshObject(scene, std::nullopt));
  const double w = question.width;

  Scene linear = scene;
  linear.model.kind = "fem";
  linear.model.fem.element = FemOptions::Element::kTet10;
  linear.model.fem.law = FemOptions::Law::kLinear;
  linear.model.range = 1;
  const ObjectMesh fine = GradedTo(coarse, press, w, w / 8);
  const SurfaceMesh skin = SurfaceOf(std::get<SolidMesh>(fine));
  const auto model = MakeModel(linear, fine);
  const auto seen = [&](double width) {
    return width * (1 + study::WidthMismatch(fine, linear.model, press, width));
  };
  const double d = question.small_depth;
  const double thin = ForceOf(model.get(), skin, press, 0.9 * w, d),
               thick = ForceOf(model.get(), skin, press, 1.1 * w, d);
  const double slope = std::log(thick / thin) / std::log(seen(1.1 * w) / seen(0.9 * w));
  const double force = ForceOf(model.get(), skin, press, w, d) * std::pow(seen(w) / w, -slope);

  Scene large = linear;
  large.model.kind = "fem-hyperelastic";
  large.model.fem.law = FemOptions::Law::kNeoHookean;
  const ObjectMesh rough = GradedTo(coarse, press, w, w / 4);
  const SurfaceMesh rough_skin = SurfaceOf(std::get<SolidMesh>(rough));
  const auto rubber = MakeModel(large, rough);
  const double small = ForceOf(rubber.get(), rough_skin, press, w, d);
  double full = kUnknown;
  for (int i = 1; i <= kSteps; ++i) {
    full = ForceOf(rubber.get(), rough_skin, press, w, question.depth * i / kSteps);
  }
  return force * full / small;
}

double OnShell(const Scene& scene, const PressSpec& question, const Press& press) {
  Scene fine = scene;
  fine.model.kind = "shell";
  fine.model.elements = 2560;
  const ObjectMesh mesh = MeshObject(fine, std::nullopt);
  const auto model = MakeModel(fine, mesh);
  const Contact contact{Contact::Kind::kDisplacement, press.p_O, -1, question.width,
                        question.depth * press.inward_O};
  ContactResponse response;
  model->Respond({&contact, 1}, {&response, 1});
  return press.inward_O.dot(response.force_O);
}

double TrueForce(const Scene& scene, const PressSpec& question, const Press& press) {
  const Geometry& geometry = scene.object.geometry;
  if (std::holds_alternative<MembraneGeometry>(geometry)) {
    return OnSolidMembrane(scene, question, press);
  }
  if (IsVolume(geometry)) return OnVolume(scene, question, press);
  if (scene.model.wall > 0) return OnShell(scene, question, press);
  const auto stiffness = study::PlanarStiffness(scene, press, question.width);
  return stiffness ? stiffness->value * question.depth : kUnknown;
}

}  // namespace

std::vector<double> TrueForces(const Scene& scene, const PressSpec& question) {
  if (IsPlanar(scene.object.geometry) && scene.model.wall == 0 &&
      scene.model.contact == ContactLaw::kFrictionless) {
    return LimitOfBoundaryElements(scene, question);
  }
  std::vector<double> forces;
  for (const Press& press : question.presses) forces.push_back(TrueForce(scene, question, press));
  return forces;
}

}  // namespace palpate::trade
