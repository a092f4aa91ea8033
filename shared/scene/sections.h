// The sections of a scene, each read by its own function, before what depends on several of them.
#pragma once

#include <vector>

#include "shared/scene/scene.h"
#include "shared/scene/scene_loader.h"
#include "shared/scene/section.h"

namespace palpate {

// What reading a section needs to know of the others.
struct SceneContext {
  std::filesystem::path folder;  // relative paths start here
  SceneUse use = SceneUse::kFull;
};

// `object`. Leaves geometry, material and fixed as far as they could be read.
Object ReadObject(Section& scene, const SceneContext& context);
// Its parts; `geometry` decides what may be held.
Geometry ReadGeometry(Section& object, const SceneContext& context);
std::vector<Fixed> ReadFixed(Section& object, const SceneContext& context,
                             const Geometry& geometry);
// Rotation about the fixed axes x, y, z in turn: R = R_z R_y R_x. `angles` [rad].
Eigen::Matrix3d FixedAxesRotation(const Eigen::Vector3d& angles);
// `pose` below `section`: translation and rotation about fixed x, y, z in turn; `fallback` if it is
// absent. Only what keeps the plane z = 0 in place is accepted: translation in it, rotation about
// z.
Eigen::Isometry3d ReadPlanarPose(Section& section, const Eigen::Isometry3d& fallback);
// The same without the restriction to a plane.
Eigen::Isometry3d ReadPose(Section& section, const Eigen::Isometry3d& fallback);

// `sense`; the camera's pose is `X_SC` unless the scene says otherwise. Full use needs a camera
// with tip and contour, or fingertips.
Sense ReadSense(Section& scene, const SceneContext& context, const Eigen::Isometry3d& X_SC);
// `tactile` below `sense`; nullopt: absent. Fingers without a pose are not placed yet.
std::optional<Tactile> ReadTactile(Section& sense, const SceneContext& context);
// The file named at `key`, in the scene's folder; empty if the key is absent. Full use refuses one
// that does not exist.
std::filesystem::path ReadExistingFile(Section& section, std::string_view key,
                                       const SceneContext& context);
ModelOptions ReadModel(Section& scene, const SceneContext& context);
// `site`.
SiteOptions ReadSite(Section& scene);
// `study`: {contacts: [[x, y, z], ...]}, at most a hundred; empty where nothing is asked for.
std::vector<Eigen::Vector3d> ReadStudyContacts(Section& scene);

// The object's bounding box in S; what defaults are measured by.
struct BoundingBox {
  Eigen::Vector3d lower{-1, -1, 0}, upper{1, 1, 0};  // [m]
  [[nodiscard]] Eigen::Vector3d centre() const { return 0.5 * (lower + upper); }
  [[nodiscard]] double larger_side() const { return (upper - lower).maxCoeff(); }
  [[nodiscard]] bool is_flat() const { return lower.z() == upper.z(); }
};
// Of an outline, in the plane z = 0. nullopt: no outline, or it is found later, in a picture, or
// the geometry has mistakes.
std::optional<BoundingBox> OutlineBox(const Object& object);
// Of a volume; a mesh file is read for it, and refused if it cannot be. nullopt: no volume, or
// there are mistakes already.
std::optional<BoundingBox> VolumeBox(const Object& object, const Section& scene);

// Hangs fingers without a pose over the box by 7 % of its larger side: axis along x, the pad's apex
// above the middle. Without a box: F is S.
void PlaceFingers(const std::optional<BoundingBox>& box, Tactile* tactile);

// `operator`, with a press of 5.5 % of the larger side at four times that per second by default;
// `box` is absent where the outline is not known yet.
OperatorOptions ReadOperator(Section& scene, const std::optional<BoundingBox>& box);
// `manipulator`, by default at home above the box by 7 % of its larger side, with a workspace
// larger than the box by its larger side on every side, 2.5 times as fast as the press. `pad`: the
// apex of the first finger's pad in S, which then is home and lies in the workspace.
ManipulatorOptions ReadManipulator(Section& scene, const std::optional<BoundingBox>& box,
                                   double press_speed, const std::optional<Eigen::Vector3d>& pad);
// `tool`, pointing from `home` along the axis towards the box by default.
std::optional<Tool> ReadTool(Section& scene, bool is_needed, const std::optional<BoundingBox>& box,
                             const Eigen::Vector3d& home);

}  // namespace palpate
