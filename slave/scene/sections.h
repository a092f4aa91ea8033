// The sections of a scene, each read by its own function, before checks that depend on several of
// them.
#pragma once

#include <memory>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/scene/scene_loader.h"
#include "slave/scene/section.h"

namespace palpate {

// Information about the other sections that a reader needs.
struct SceneContext {
  std::filesystem::path folder;  // relative paths start here
  SceneUse use = SceneUse::kFull;
  std::shared_ptr<const GivenMesh> mesh{};  // mesh to use instead of a mesh file; nullptr: none
};

// `object`. After mistakes the result contains the parts of geometry, material and fixed that could
// be read.
Object ReadObject(Section& scene, const SceneContext& context);
// The parts of `object`; `geometry` decides which parts can be fixed.
Geometry ReadGeometry(Section& object, const SceneContext& context);
std::vector<Fixed> ReadFixed(Section& object, const Geometry& geometry);
// Rotation about the fixed axes x, y, z in turn: R = R_z R_y R_x. `angles` [rad].
Eigen::Matrix3d FixedAxesRotation(const Eigen::Vector3d& angles);
// `pose` below `section`: translation and rotation about fixed x, y, z in turn; `fallback` if it is
// absent. Only poses that keep the plane z = 0 are accepted: translation in it, rotation about z.
Eigen::Isometry3d ReadPlanarPose(Section& section, const Eigen::Isometry3d& fallback);
// Reads a pose like ReadPlanarPose, but any pose is accepted.
Eigen::Isometry3d ReadPose(Section& section, const Eigen::Isometry3d& fallback);
// Reads a pose like ReadPose, but rejects a pose that is absent or empty.
Eigen::Isometry3d ReadKnownPose(Section& section);

// Information about the other sections that the reader of a sensing needs.
struct SenseSetting {
  const SceneContext& context;
  const Object& object;
  const Eigen::Isometry3d& X_SC;  // default of one camera
};
// `sense`. Full use needs a camera with tip and contour, a stereo pair or depth images, or
// fingertips.
SenseOptions ReadSense(Section& scene, const SenseSetting& setting);
constexpr int kMaxImage = 16384;  // edge [px]
// `size` below a camera: [width, height] in pixels.
std::array<int, 2> ReadSize(Section& camera, const std::array<int, 2>& fallback);
// The images at `key`: a printf pattern, a glob, a directory or a file, in the scene's folder. Full
// use rejects a pattern without an image.
std::string ReadImages(Section& section, std::string_view key, const SceneContext& context);
// `url` below a camera: a stream's address or a GStreamer pipeline.
std::string ReadAddress(Section& section);
// Requires that images come from exactly one source.
bool NamesOneSource(Section& camera);
// Returns whether `camera` below `sense` (nullptr: absent) is a stereo pair or depth camera.
bool NamesStereoOrDepth(const DocumentNode* sense);
// `camera` and `points` below `sense`, in that case; nullopt: other sensing, or mistakes. A
// simulated pair is 250 mm inside (paper C), at negative z of O, with its left camera's x along
// that of O, and looks at O's origin. Other cameras need a pose, unless the object has no fixed
// boundary.
std::optional<SenseChoice> ReadStereoOrDepth(Section& sense, const SenseSetting& setting);
// `points` below `sense`. By default a membrane has the dots of paper C, scaled to its size,
// another object is tracked by its texture, and a depth image by its surface.
PointTracking ReadPoints(Section& sense, const SenseSetting& setting, const StereoOrDepth& cameras);
// `tactile` below `sense`; nullopt: absent. Fingers without a pose are not placed yet.
std::optional<Tactile> ReadTactile(Section& sense, const SceneContext& context);
// The file at `key`, in the scene's folder; empty if the key is absent. Full use rejects a file
// that does not exist.
std::filesystem::path ReadExistingFile(Section& section, std::string_view key,
                                       const SceneContext& context);
ModelOptions ReadModel(Section& scene, const SceneContext& context);
// Reads `site`.
SiteOptions ReadSite(Section& scene);
// `study`: {contacts: [[x, y, z], ...]}, at most a hundred; empty if absent.
std::vector<Eigen::Vector3d> ReadStudyContacts(Section& scene);

// The object's bounding box in S, the base of many defaults.
struct BoundingBox {
  Eigen::Vector3d lower{-1, -1, 0}, upper{1, 1, 0};  // [m]
  [[nodiscard]] Eigen::Vector3d centre() const { return 0.5 * (lower + upper); }
  [[nodiscard]] double larger_side() const { return (upper - lower).maxCoeff(); }
  [[nodiscard]] bool is_flat() const { return lower.z() == upper.z(); }
};
// Box of an outline in the plane z = 0. nullopt: no outline, or it is found later in an image, or
// the geometry has mistakes.
std::optional<BoundingBox> OutlineBox(const Object& object);
// Box of a volume or a membrane; a mesh file is read for it, and refused if it cannot be. nullopt:
// none of them, or there are mistakes already.
std::optional<BoundingBox> SolidBox(const Object& object, const Section& scene);

// Places fingers without a pose above the box at 7 % of its larger side: axis along x, the pad's
// apex above the centre. Without a box F is S.
void PlaceFingers(const std::optional<BoundingBox>& box, Tactile* tactile);

// `operator`, by default with an indentation of 5.5 % of the larger side at four times that per
// second; `box` is absent if the outline is not known yet.
OperatorOptions ReadOperator(Section& scene, const std::optional<BoundingBox>& box);
// `link`.
LinkOptions ReadLink(Section& scene);
// `manipulator`. Defaults: home is 7 % of the larger side above the box, for a membrane in front of
// its centre. The workspace exceeds the box by its larger side on every side. The speed is 2.5
// times that of the operator's contact. `pad`: the apex of the first finger's pad in S, which then
// is home and must be in the workspace.
ManipulatorOptions ReadManipulator(Section& scene, const Object& object,
                                   const std::optional<BoundingBox>& box, double press_speed,
                                   const std::optional<Eigen::Vector3d>& pad);
// `tool`, by default as wide as the rule defines, pointing from `home` along the axis towards the
// box.
std::optional<Tool> ReadTool(Section& scene, bool is_needed, const Rule& width,
                             const std::optional<BoundingBox>& box, const Eigen::Vector3d& home);
// The tool of a scene that names none: round, a fifteenth of the larger side wide.
Tool UsualTool(const BoundingBox& box);

}  // namespace palpate
