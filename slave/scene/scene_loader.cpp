#include "slave/scene/scene_loader.h"

#include <algorithm>
#include <array>
#include <optional>

#include "shared/text/text.h"
#include "slave/scene/document.h"
#include "slave/scene/membrane_limits.h"
#include "slave/scene/model_kinds.h"
#include "slave/scene/section.h"
#include "slave/scene/sections.h"

namespace palpate {
namespace {

Eigen::Isometry3d CameraOver(const std::optional<BoundingBox>& box) {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();
  if (box) X_SC.translation() = box->centre();
  return X_SC;
}

// Returns the number of boundary elements of the object; more than requested if the outline has
// more edges.
int ElementCount(const Scene& scene) {
  const auto& geometry = scene.object.geometry;
  if (std::holds_alternative<DiscGeometry>(geometry)) return scene.model.elements;
  const Outline outline = OutlineOf(geometry);
  std::size_t edges = outline.outer.size();
  for (const auto& hole : outline.holes) edges += hole.size();
  return std::max(scene.model.elements, static_cast<int>(edges));
}

// Checks that depend on several sections.
class CrossCheck {
 public:
  CrossCheck(const Scene& scene, const DocumentNode& document, SceneUse use, Mistakes* mistakes)
      : scene_(scene), document_(document), use_(use), mistakes_(mistakes) {}

  void Run() {
    CheckGeometry();
    CheckHeld();
    CheckKind();
    CheckTool();
    CheckRegions();
    CheckRelaxation();
    CheckPuncture();
    if (OutlineBox(scene_.object)) CheckElements();
    CheckHome();
    CheckTemplate();
    CheckFingers();
    CheckSight();
    CheckMembrane();
    CheckContour();
    CheckMotion();
    CheckEmbryo();
  }

 private:
  // Checks that the kind of sensing can measure the object.
  void CheckGeometry() {
    if (use_ != SceneUse::kFull) return;
    const Geometry& geometry = scene_.object.geometry;
    if (scene_.sense.Find<Tactile>() && !IsVolume(geometry)) {
      Refuse("object.geometry", "box or mesh with fingertips");
    } else if (HasStereoOrDepth(scene_.sense) && IsPlanar(geometry)) {
      Refuse("object.geometry", "membrane, box or mesh with a stereo pair or depth images");
    } else if (std::holds_alternative<DomeGeometry>(geometry) && !HasTrueStereoOrDepth()) {
      Refuse("object.geometry.membrane",
             "a `radius`, unless its images come from files, cameras or a driver: a domed membrane "
             "is not simulated, solved or studied");
    } else if (scene_.sense.Find<CameraOptions>() && !IsPlanar(geometry)) {
      Refuse("object.geometry",
             "rectangle, disc, polygon or contour with one camera; membranes, boxes and meshes "
             "need a stereo pair (`camera: {source: simulated, pair: {}}` or `camera: {stereo: "
             "{left, right, rig}}`), depth images (`camera: {depth: ...}`) or fingertips "
             "(`tactile`), and no sensing for solve, study and check");
    }
  }

  [[nodiscard]] bool HasTrueStereoOrDepth() const {
    const auto* stereo = scene_.sense.Find<StereoCameras>();
    return HasStereoOrDepth(scene_.sense) &&
           (stereo == nullptr || stereo->source != StereoCameras::Source::kSimulated);
  }

  // Requires supports. Two cameras may also track an unsupported body, such as a simulated target.
  void CheckHeld() {
    const auto* stereo = scene_.sense.Find<StereoCameras>();
    const bool is_given = IsPresent("object", "fixed");
    const bool may_move = names_cameras_ && !scene_.sense.Find<DepthImages>();
    if (use_ == SceneUse::kFull && !may_move && !is_given && !IsHeld(scene_.object)) {
      Refuse("object.fixed", "the fixed part of the object: side, arc, plane or nodes");
    }
    const bool is_target = stereo && stereo->source == StereoCameras::Source::kSimulated &&
                           IsVolume(scene_.object.geometry);
    if (use_ == SceneUse::kFull && is_target && is_given) {
      Refuse("object.fixed",
             "nothing with a simulated textured target, because it moves as a rigid body");
    }
  }

  // Checks that the model can compute the object.
  void CheckKind() {
    const Geometry& geometry = scene_.object.geometry;
    const std::string& kind = scene_.model.kind;
    if (scene_.model.prestress > 0 && !IsSkin(geometry)) {
      Refuse("model.prestress", "nothing here: only a membrane is under tension at rest");
    }
    constexpr std::array kObjectNames{" for a planar outline", " for a membrane", " for a volume",
                                      " for a domed membrane"};
    const ObjectClass object = ClassOf(geometry);
    if (!IsKindFor(object, kind)) {
      Refuse("model.kind", KindsFor(object) + kObjectNames[static_cast<std::size_t>(object)]);
    }
  }

  // Rejects tools that the model does not support, and keys that no model of the object uses.
  void CheckTool() {
    const Geometry& geometry = scene_.object.geometry;
    if (IsPresent("tool", "depth") && !IsPlanar(geometry)) {
      Refuse("tool.depth", "nothing here: only a planar object has a thickness to reach through");
    }
    CheckExtruded();
    if (IsPresent("tool", "load") && !(ClassOf(geometry) == ObjectClass::kMembrane &&
                                       scene_.tool->shape == Tool::Shape::kFlat)) {
      Refuse("tool.load", "nothing here: only a flat tool on a flat membrane has a load");
    }
    if (!scene_.tool || scene_.tool->shape == Tool::Shape::kFlat ||
        scene_.tool->shape == Tool::Shape::kRound || FollowsTools(scene_.model)) {
      return;
    }
    Refuse("tool.shape",
           "flat or round with this model: others need fem with element: tet4, time: static");
  }

  // Checks the keys for the tool's position through the thickness.
  void CheckExtruded() {
    const std::string& kind = scene_.model.kind;
    if (scene_.tool && scene_.tool->behind && kind != "extruded" && kind != "auto") {
      Refuse("tool.behind", "nothing with this model.kind: use extruded");
    }
    if (kind != "extruded" || !scene_.tool || !IsPlanar(scene_.object.geometry)) return;
    const double T = ThicknessOf(scene_.object.geometry);
    if (scene_.tool->shape != Tool::Shape::kFlat) {
      Refuse("tool.shape", "flat with model.kind: extruded");
    } else if (!scene_.tool->depth) {
      Refuse("tool.depth", "how far the tool reaches through the thickness, with extruded");
    } else if (scene_.tool->behind &&
               *scene_.tool->behind + std::min(*scene_.tool->depth, T) > T * (1 + 1e-9)) {
      Refuse("tool.behind", "a tool that ends within the thickness");
    }
    if (scene_.object.material.poisson_ratio > kMaxExtrudedNu) {
      Refuse("object.material.poisson_ratio",
             Formatted("at most %g with model.kind: extruded", kMaxExtrudedNu));
    }
  }

  void CheckRegions() {
    if (scene_.object.regions.empty()) return;
    const ModelKind* kind = FindModelKind(scene_.model.kind);
    if (!IsVolume(scene_.object.geometry)) {
      Refuse("object.regions", "nothing here: only a box or a mesh has regions");
    } else if (kind != nullptr && !kind->takes_regions) {
      Refuse("object.regions",
             "nothing with this model.kind: use " + KindsWith(&ModelKind::takes_regions));
    }
  }

  // Requires a named model for relaxing materials, because `auto` compares models of elastic
  // bodies.
  void CheckRelaxation() {
    if (scene_.object.material.relaxation.empty()) return;
    const ModelKind* kind = FindModelKind(scene_.model.kind);
    if (kind != nullptr && kind->takes_relaxation) return;
    Refuse("object.material.relaxation",
           "nothing with this model.kind: use " + KindsWith(&ModelKind::takes_relaxation));
  }

  // Refuses punctures with fingertips, because they measure the force, so no model sets it to zero.
  void CheckPuncture() {
    if (scene_.sense.Find<Tactile>() && scene_.model.puncture_depth > 0) {
      Refuse("model.puncture.depth", "nothing with fingertips: only cameras detect a puncture");
    }
    if (scene_.model.puncture_from > 0 && scene_.sense.all().size() > 0 &&
        !(scene_.sense.all().size() == 1 && scene_.sense.Find<CameraOptions>())) {
      Refuse("model.puncture.from",
             "nothing here: it applies to one camera, which sees the surface spring back");
    }
  }

  void CheckElements() {
    if (std::holds_alternative<RectangleGeometry>(scene_.object.geometry) &&
        scene_.model.elements < 4) {
      Refuse("model.elements", "4 to 4000 for a rectangle");
    }
    for (const Fixed& fixed : scene_.object.fixed) {
      const auto* listed = std::get_if<FixedNodes>(&fixed.where);
      const int last = ElementCount(scene_) - 1;
      const auto is_beyond = [&](int node) { return node > last; };
      if (listed == nullptr || std::ranges::none_of(listed->nodes, is_beyond)) continue;
      Refuse("object.fixed", "nodes from 0 to " + std::to_string(last) + ", the last element");
    }
  }

  // Checks that home is outside, because a first tip inside the object would count as contact.
  void CheckHome() {
    const Eigen::Vector3d p_O = scene_.object.X_SO.inverse() * scene_.manipulator.home;
    if (scene_.tool && !scene_.sense.Find<Tactile>() &&
        Contains(OutlineOf(scene_.object.geometry), p_O.head<2>())) {
      Refuse("manipulator.home", "a position outside the object");
    }
    const bool is_membrane = IsSkin(scene_.object.geometry);
    const bool is_given = IsPresent("manipulator", "home");
    if (is_membrane && HasStereoOrDepth(scene_.sense) && is_given && !(p_O.z() > 0)) {
      Refuse("manipulator.home",
             "a position in front of the membrane, on the side of positive z of O");
    }
  }

  // Requires a template without a manipulator, because nothing else determines the tip in the first
  // image.
  void CheckTemplate() {
    const auto* tip = scene_.sense.Find<TipTracking>();
    const bool is_alone = scene_.manipulator.source == ManipulatorOptions::Source::kNone;
    if (use_ != SceneUse::kFull || !is_alone || tip == nullptr || !tip->template_file.empty())
      return;
    Refuse("sense.tip.template", "an image of the tip, which `manipulator: none` needs");
  }

  // Checks the fingers. A recording with poses replaces those of the scene.
  void CheckFingers() {
    const auto* box = std::get_if<BoxGeometry>(&scene_.object.geometry);
    const auto* tactile = scene_.sense.Find<Tactile>();
    if (box == nullptr || !tactile || tactile->has_recorded_poses) return;
    for (const Finger& finger : tactile->fingers) {
      const Eigen::Vector3d p_O = scene_.object.X_SO.inverse() * finger.X_SF.translation();
      const bool is_inside = (p_O.array() > 0).all() && (p_O.array() < box->size.array()).all();
      if (!is_inside) continue;
      const bool is_named = document_.Find("sense")->Find("tactile")->Find("fingers") != nullptr;
      Refuse(is_named ? "sense.tactile.fingers." + finger.name + ".pose" : "sense.tactile.pose",
             "a fingertip whose centre lies outside the object");
    }
  }

  // Checks that cameras look at the object and that the baseline of a simulated pair is less than
  // its distance.
  void CheckSight() {
    const auto* stereo = scene_.sense.Find<StereoCameras>();
    const bool is_simulated = stereo && stereo->source == StereoCameras::Source::kSimulated;
    const bool is_membrane = IsSkin(scene_.object.geometry);
    if (!HasStereoOrDepth(scene_.sense) || !(is_simulated || is_membrane) || mistakes_->count() > 0)
      return;
    const Eigen::Isometry3d& X_SC = stereo ? stereo->X_SL : scene_.sense.Find<DepthImages>()->X_SD;
    const Eigen::Vector3d p_C = X_SC.inverse() * scene_.object.X_SO.translation();
    constexpr double kWidest = 1.5;  // baseline / distance: the cameras turn by 97 degrees
    if (use_ == SceneUse::kFull && !(p_C.z() > 0)) {
      Refuse("sense.camera.pose", "a pose with the object's origin in front of the camera, z > 0");
    } else if (is_simulated && !(stereo->baseline < kWidest * p_C.norm())) {
      Refuse("sense.camera.pair.baseline", "less than 1.5 times the distance to the object");
    }
  }

  // Checks the limits of the membrane models and of the simulated membrane.
  void CheckMembrane() {
    const MembraneLimits limits(scene_);
    if (!limits.apply() || mistakes_->count() > 0) return;
    if (!limits.allows_thickness()) {
      Refuse("object.geometry.membrane.thickness", limits.thickness());
      return;
    }
    if (use_ != SceneUse::kFull || !limits.is_simulated()) return;
    if (!limits.allows_prestress()) Refuse("model.prestress", limits.prestress());
    if (!limits.allows_press()) Refuse("operator.press.depth", limits.press());
    if (!limits.allows_home()) {
      const bool is_moved = !IsPresent("manipulator", "home") && IsPresent("site", "misplacement");
      Refuse(is_moved ? "site.misplacement" : "manipulator.home", limits.home());
    }
    if (scene_.site.blur > MembraneLimits::kMaxBlur) Refuse("site.blur", MembraneLimits::kBlur);
  }

  void CheckContour() {
    if (!std::holds_alternative<ImageContourGeometry>(scene_.object.geometry)) return;
    if (!scene_.sense.Find<ContourTracking>()) {
      Refuse("sense.contour", "{track: snake}, which `contour: from-image` needs");
    }
    const auto* camera = scene_.sense.Find<Camera>();
    const bool has_shape = scene_.site.embryo && scene_.site.embryo->radius > 0;
    if (camera && camera->source == Camera::Source::kSimulated && !has_shape) {
      Refuse("sense.camera.source",
             "file or device: with `from-image` a simulation needs site.embryo.radius as shape");
    }
  }

  void CheckMotion() {
    const bool moves = !scene_.site.motion.amplitude.isZero(0);
    const bool is_shown = scene_.sense.Find<Camera>() && scene_.sense.Find<TipTracking>();
    if (moves && use_ == SceneUse::kFull && !is_shown) {
      Refuse("site.motion", "nothing here: it applies to one camera that tracks a tool");
    }
  }

  // Checks that an embryo is a disc under one simulated camera.
  void CheckEmbryo() {
    if (!scene_.site.embryo) return;
    const auto* camera = scene_.sense.Find<Camera>();
    const Geometry& geometry = scene_.object.geometry;
    if (use_ == SceneUse::kFull && !camera) {
      Refuse("site.embryo", "nothing here: it applies to one camera");
    }
    if (!std::holds_alternative<DiscGeometry>(geometry) &&
        !std::holds_alternative<ImageContourGeometry>(geometry)) {
      Refuse("site.embryo", "a disc, or a contour from the image, as object.geometry");
    }
  }

  [[nodiscard]] bool IsPresent(std::string_view section, std::string_view key) const {
    const DocumentNode* node = document_.Find(section);
    return node != nullptr && node->Find(key) != nullptr;
  }
  void Refuse(std::string_view path, std::string_view accepted) {
    mistakes_->AddAtPath(document_, path, accepted);
  }

  const Scene& scene_;
  const DocumentNode& document_;
  SceneUse use_;
  Mistakes* mistakes_;
  bool names_cameras_ = NamesStereoOrDepth(document_.Find("sense"));
};

Scene ReadScene(Section& root, const SceneContext& context) {
  Scene scene;
  scene.name = root.Text("name", "a name");
  scene.object = ReadObject(root, context);
  scene.model = ReadModel(root, context);
  auto box = OutlineBox(scene.object);
  scene.sense = ReadSense(root, {context, scene.object, CameraOver(box)});
  if (HasStereoOrDepth(scene.sense) && !box) box = SolidBox(scene.object, root);
  std::optional<Eigen::Vector3d> pad;
  if (auto* tactile = scene.sense.Find<Tactile>()) {
    if (IsVolume(scene.object.geometry)) box = SolidBox(scene.object, root);
    PlaceFingers(box, tactile);
    pad = tactile->fingers.front().X_SF * Eigen::Vector3d(0, 0, -tactile->finger_radius);
  }
  scene.operator_options = ReadOperator(root, box);
  scene.manipulator =
      ReadManipulator(root, scene.object, box, scene.operator_options.press_speed, pad);
  scene.link = ReadLink(root);
  const bool has_cameras = HasStereoOrDepth(scene.sense);
  const bool has_no_other = scene.sense.all().empty() || scene.sense.Find<CameraOptions>();
  const bool needs_tool = context.use == SceneUse::kFull && has_no_other;
  scene.tool =
      ReadTool(root, needs_tool, MembraneLimits(scene).width_rule(), box, scene.manipulator.home);
  if (has_cameras && !scene.tool && box) scene.tool = UsualTool(*box);
  scene.site = ReadSite(root);
  scene.study_contacts = ReadStudyContacts(root);
  return scene;
}

// `document`: without mistakes so far, or empty.
Scene InterpretScene(const DocumentNode& document, const SceneContext& context,
                     Mistakes* mistakes) {
  const auto stop_at_mistakes = [&] {
    if (mistakes->count() > 0) throw SceneError(mistakes->text(), mistakes->list());
  };
  if (document.children.empty()) stop_at_mistakes();
  Scene scene;
  {
    Section root(&document, "", mistakes);
    scene = ReadScene(root, context);
  }
  CrossCheck(scene, document, context.use, mistakes).Run();
  stop_at_mistakes();
  return scene;
}

}  // namespace

Scene LoadScene(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                SceneUse use) {
  Mistakes mistakes(file);
  const DocumentNode document = ReadDocument(file, overrides, &mistakes);
  Scene scene = InterpretScene(document, {file.parent_path(), use}, &mistakes);
  scene.file = file;
  scene.overrides = overrides;
  return scene;
}

Scene ParseScene(const std::string& text, std::shared_ptr<const GivenMesh> mesh) {
  Mistakes mistakes("scene");
  const DocumentNode document = ParseDocument(text, &mistakes);
  return InterpretScene(document, {{}, SceneUse::kSolve, std::move(mesh)}, &mistakes);
}

}  // namespace palpate
