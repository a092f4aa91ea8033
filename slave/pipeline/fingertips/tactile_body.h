// The object in a scene with fingertips: its surface and its model.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/local_model/contact_stiffness.h"
#include "slave/program/precompute_progress.h"
#include "slave/scene/scene.h"

namespace palpate {

// The part that SetModel replaces as a whole.
struct TactileBody final : PreparedModel {
  [[nodiscard]] const ModelInfo& info() const override { return deformation->info(); }

  SurfaceMesh surface;  // at rest, frame O; inner nodes too
  // Stops equilibrium iterations after a tenth of a second, because a sample cannot wait longer.
  // They then fail.
  PrecomputeProgress limit{false};
  std::unique_ptr<DeformationModel> deformation;
  std::unique_ptr<SurfaceContact> contact;
  std::unique_ptr<ContactStiffness> stiffness;
  // The surface without inner nodes, for observers: its nodes by their numbers in `surface`, its
  // triangles by those in `skin`.
  std::vector<int> skin;
  std::vector<std::uint32_t> skin_triangles;
  std::vector<std::uint32_t> skin_held;  // its fixed nodes, by their number in `skin`
  double larger_side = 0;                // of the bounding box [m]
  double largest_force = 0;    // largest accepted force: E times the larger side squared [N]
  bool moves_in_time = false;  // a Respond is one sample's period
  bool has_friction = false;   // contacts are rigid tools, whose force depends on their path
};

// `time: dynamic` steps once per sample, independent of model.step. Throws std::invalid_argument:
// an object that is not a volume; see MeshObject, MakeModel.
std::unique_ptr<TactileBody> MakeTactileBody(const Scene& scene, Progress* progress = nullptr);
// The scene with the time step that fingertips need.
Scene InStepWithSamples(const Scene& scene);

}  // namespace palpate
