#include "tests/campaigns/model_selection/truth.h"

#include <limits>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/study/reference.h"
#include "slave/study/volume_stiffness.h"

namespace palpate::model_selection {
namespace {

using study::Press;
using study::PressSpec;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// --- membranes
double OnSolidMembrane(const Scene& scene, const PressSpec& question, const Press& press) {
  constexpr int kSteps = 6;
  simulation::PressedMembrane membrane(std::get<MembraneGeometry>(scene.object.geometry),
                                       scene.object.material, question.width, press.p_O.head<2>(),
                                       {}, 0, simulation::FaceOf(scene.tool.value_or(Tool{})));
  for (int i = 1; i <= kSteps; ++i) {
    if (!membrane.Deepen(question.depth * i / kSteps)) return kUnknown;
  }
  return -membrane.press().depth_steps.back()->force;
}

// --- volumes
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

// Returns the ratio of the object's force at the depth to the linear force.
double StiffeningAt(const Scene& scene, const PressSpec& question, const Press& press) {
  constexpr int kSteps = 4;
  Scene large = scene;
  large.model.kind = "fem";
  large.model.fem.element = FemOptions::Element::kTet10;
  large.model.fem.law = FemOptions::Law::kNeoHookean;
  large.model.range = 1;
  const ObjectMesh mesh = study::GradedUnder(scene, press, question.width, question.width / 2);
  const SurfaceMesh skin = SurfaceOf(std::get<SolidMesh>(mesh));
  const auto rubber = MakeModel(large, mesh);
  const auto force = [&](double depth) {
    return ForceOf(rubber.get(), skin, press, question.width, depth);
  };
  const double linear = force(question.small_depth) / question.small_depth;
  double full = kUnknown;
  for (int i = 1; i <= kSteps; ++i) full = force(question.depth * i / kSteps);
  return full / (linear * question.depth);
}

// The stiffening is computed for the first press only: it depends on depth and width, not on the
// place.
std::vector<double> OnVolume(const Scene& scene, const PressSpec& question) {
  const double w = question.width;
  constexpr double kGrowth = 1;  // of the edges, a half of the time; within 1e-3 of 0.7
  const double stiffening = StiffeningAt(scene, question, question.presses.front());
  std::vector<double> forces;
  for (const Press& press : question.presses) {
    const auto stiffness = study::VolumeStiffness(scene, press, w, w / 5, kGrowth);
    forces.push_back(stiffness.value_or(kUnknown) * question.depth * stiffening);
  }
  return forces;
}

double TrueForce(const Scene& scene, const PressSpec& question, const Press& press) {
  const Geometry& geometry = scene.object.geometry;
  if (std::holds_alternative<MembraneGeometry>(geometry)) {
    return OnSolidMembrane(scene, question, press);
  }
  const auto stiffness =
      study::PlanarStiffness(scene, press, question.width, study::PlanarMesh::kMedium);
  return stiffness.value_or(kUnknown) * question.depth;
}

}  // namespace

std::vector<double> TrueForces(const Scene& scene, const PressSpec& question) {
  if (IsVolume(scene.object.geometry)) return OnVolume(scene, question);
  std::vector<double> forces;
  for (const Press& press : question.presses) forces.push_back(TrueForce(scene, question, press));
  return forces;
}

}  // namespace palpate::model_selection
