// Operator, manipulator, tool, link, simulated environment and study of a scene.
#include <cmath>
#include <limits>

#include "slave/scene/sections.h"

namespace palpate {
namespace {

constexpr double kPressDepth = 0.055;    // of the larger side
constexpr double kPressPerSecond = 4;    // press depths per second
constexpr double kHomeClearance = 0.07;  // of the larger side
constexpr double kSpeedReserve = 2.5;    // times the press speed
constexpr double kToolPerSide = 1.0 / 15;

// Returns the start position of a press.
Eigen::Vector3d HomeOver(const Object& object, const BoundingBox& box) {
  const double clearance = kHomeClearance * box.larger_side();
  const Eigen::Vector3d centre = box.centre();
  if (box.is_flat()) return {centre.x(), box.upper.y() + clearance, 0};
  if (IsVolume(object.geometry)) return {centre.x(), centre.y(), box.upper.z() + clearance};
  return object.X_SO * Eigen::Vector3d(0, 0, clearance);
}

ManipulatorOptions DefaultManipulator(const Object& object, const std::optional<BoundingBox>& box,
                                      double press_speed) {
  ManipulatorOptions options;
  options.max_speed = kSpeedReserve * press_speed;
  if (!box) return options;
  const double side = box->larger_side();
  const Eigen::Vector3d margin(side, side, box->is_flat() ? 0 : side);
  options.home = HomeOver(object, *box);
  options.workspace_min = box->lower - margin;
  options.workspace_max = box->upper + margin;
  return options;
}

// Returns the direction towards the box along the axis in which `home` is farthest outside of it.
// Without a box it is zero, because only the image determines it.
Eigen::Vector2d TowardsBox(const std::optional<BoundingBox>& box, const Eigen::Vector3d& home) {
  if (!box) return {0, 0};
  // > 0: home is left of it / below it.
  const Eigen::Vector2d below = (box->lower - home).head<2>();
  const Eigen::Vector2d beyond = (home - box->upper).head<2>();
  const Eigen::Vector2d outside = below.cwiseMax(beyond);
  const int axis = outside.x() > outside.y() ? 0 : 1;
  Eigen::Vector2d direction(0, 0);
  direction[axis] = below[axis] > beyond[axis] ? 1 : -1;
  return direction;
}

void ReadGuards(Section& section, ManipulatorOptions* options) {
  options->force_guard = section.Number("force_guard", options->force_guard);
  options->depth_guard = section.Number("depth_guard", options->depth_guard);
  options->guard_retracts = section.OneOf<bool>("guard", {{"hold", false}, {"retract", true}});
  options->blind_after = section.Number("blind_after");
}

bool IsWithoutManipulator(Section& scene) {
  const DocumentNode* node = scene.Has("manipulator") ? scene.node()->Find("manipulator") : nullptr;
  return node != nullptr && node->text == "none";
}

void ReadArm(Section& section, ManipulatorOptions* options) {
  using Source = ManipulatorOptions::Source;
  options->source = section.OneOf<Source>(
      "source", {{"simulated", Source::kSimulated}, {"stream", Source::kStream}});
  if (section.Has("silence")) {
    options->silence = section.Number("silence");
    if (options->source != Source::kStream) {
      section.Refuse("silence", "nothing here: it applies to `source: stream` only");
    }
  }
}

}  // namespace

OperatorOptions ReadOperator(Section& scene, const std::optional<BoundingBox>& box) {
  OperatorOptions options;
  if (box) {
    options.press_depth = kPressDepth * box->larger_side();
    options.press_speed = kPressPerSecond * options.press_depth;
  }
  Section section = scene.Open("operator");
  TeleopTransform& transform = options.transform;
  transform.position_scale = section.Number("position_scale");
  transform.force_scale = section.Number("force_scale");
  options.force_limit = section.Number("force_limit");
  transform.R_SM = FixedAxesRotation(section.Vector3("rotation"));
  Section press = section.Open("press");
  options.press_given = press.Has("depth");
  options.press_depth = press.Number("depth", options.press_depth);
  options.press_speed = press.Number("speed", options.press_speed);
  return options;
}

LinkOptions ReadLink(Section& scene) {
  LinkOptions options;
  Section section = scene.Open("link");
  options.dead_after = section.Number("dead_after");
  return options;
}

void PlaceFingers(const std::optional<BoundingBox>& box, Tactile* tactile) {
  if (!box) return;
  const double lift = tactile->finger_radius + kHomeClearance * box->larger_side();
  for (Finger& finger : tactile->fingers) {
    if (finger.has_pose) continue;
    finger.X_SF.translation() = box->centre();
    finger.X_SF.translation().z() = box->upper.z() + lift;
  }
}

ManipulatorOptions ReadManipulator(Section& scene, const Object& object,
                                   const std::optional<BoundingBox>& box, double press_speed,
                                   const std::optional<Eigen::Vector3d>& pad) {
  ManipulatorOptions options = DefaultManipulator(object, box, press_speed);
  if (IsWithoutManipulator(scene)) {
    options.source = ManipulatorOptions::Source::kNone;
    options.home = pad.value_or(options.home);
    return options;
  }
  Section section = scene.Open("manipulator");
  ReadArm(section, &options);
  if (!pad) {
    options.home = section.Vector3("home", options.home);
  } else {
    options.home = *pad;
    options.workspace_min = options.workspace_min.cwiseMin(*pad);
    options.workspace_max = options.workspace_max.cwiseMax(*pad);
    if (section.Has("home")) {
      section.Refuse("home", "nothing here: home is the pad of the first finger, from its pose");
    }
  }
  options.max_speed = section.Number("max_speed", options.max_speed);
  options.max_angular_speed = section.Number("max_angular_speed");
  ReadGuards(section, &options);
  Section workspace = section.Open("workspace");
  options.workspace_min = workspace.Vector3("min", options.workspace_min);
  options.workspace_max = workspace.Vector3("max", options.workspace_max);
  if ((options.workspace_min.array() > options.workspace_max.array()).any()) {
    workspace.Refuse("max", "a corner with no coordinate below that of workspace.min");
  } else if ((options.home.array() < options.workspace_min.array()).any() ||
             (options.home.array() > options.workspace_max.array()).any()) {
    if (pad) {
      section.Refuse("workspace", "a workspace that contains the pad of the first finger at home");
    } else {
      section.Refuse("home", "a position inside the manipulator's workspace");
    }
  }
  return options;
}

namespace {

// Reads a length, or `whole`; nullopt: it is not stated.
std::optional<double> ReadExtent(Section& section) {
  if (!section.Has("depth")) return std::nullopt;
  if (section.node()->Find("depth")->text == "whole") {
    return std::numeric_limits<double>::infinity();
  }
  return section.Number("depth");
}

// Tools other than flat ones have a width, a radius or both. One follows from the other.
void ReadEnd(Section& section, const Rule& width, Tool* tool) {
  const bool is_rectangle = tool->shape == Tool::Shape::kRectangle;
  if (tool->shape == Tool::Shape::kCapsule || is_rectangle) {
    tool->length = section.Number("length");
    tool->axis_O = section.Vector3("axis");
    if (!(tool->axis_O.norm() > kMinValue)) section.Refuse("axis", "a vector other than [0, 0, 0]");
    tool->axis_O.stableNormalize();
  } else {
    for (const char* key : {"length", "axis"}) {
      if (section.Has(key)) section.Refuse(key, "nothing without `shape: capsule` or `rectangle`");
    }
  }
  if (tool->shape == Tool::Shape::kFlat || is_rectangle) {
    if (section.Has("radius")) section.Refuse("radius", "nothing with a flat tool");
    tool->width = section.NumberWithin("width", width);
    return;
  }
  std::optional<double> across;
  if (section.Has("radius")) {
    tool->radius = section.Number("radius");
    across = 2 * tool->radius;
  }
  tool->width = section.NumberWithin("width", width, across);
  if (!across) tool->radius = tool->width / 2;
  if (tool->radius < tool->width / 2) section.Refuse("radius", "at least half of tool.width");
}

}  // namespace

std::optional<Tool> ReadTool(Section& scene, bool is_needed, const Rule& width,
                             const std::optional<BoundingBox>& box, const Eigen::Vector3d& home) {
  Section section = scene.Open("tool", is_needed ? "a map of shape and width" : "");
  if (!section.present()) return std::nullopt;
  Tool tool;
  tool.shape = section.OneOf<Tool::Shape>("shape", {{"flat", Tool::Shape::kFlat},
                                                    {"round", Tool::Shape::kRound},
                                                    {"capsule", Tool::Shape::kCapsule},
                                                    {"rectangle", Tool::Shape::kRectangle}});
  ReadEnd(section, width, &tool);
  tool.depth = ReadExtent(section);
  if (section.Has("behind")) tool.behind = section.Number("behind");
  tool.presses_evenly = section.OneOf<bool>("load", {{"rigid", false}, {"even", true}});
  const Eigen::Vector2d usual = TowardsBox(box, home);
  const Eigen::Vector2d direction = section.Vector2("direction", usual);
  if (direction.norm() < kMinValue && !usual.isZero(0))
    section.Refuse("direction", "a direction [x, y] other than [0, 0]");
  tool.direction = direction.stableNormalized();
  return tool;
}

Tool UsualTool(const BoundingBox& box) {
  const double width = kToolPerSide * box.larger_side();
  return {.shape = Tool::Shape::kRound, .width = width, .radius = width / 2};
}

namespace {

EmbryoSite ReadEmbryo(Section& section) {
  EmbryoSite embryo;
  embryo.radius = section.Number("radius");
  embryo.linear_to = section.Number("linear_to");
  embryo.stiffening = section.Number("stiffening");
  embryo.puncture = section.Vector2("puncture");
  if (embryo.puncture[0] > embryo.puncture[1]) {
    section.Refuse("puncture", "two depths, the smaller one first");
  }
  embryo.drag = section.Number("drag");
  embryo.debris = section.Integer("debris");
  embryo.defocus = section.Number("defocus");
  return embryo;
}

}  // namespace

SiteOptions ReadSite(Section& scene) {
  Section section = scene.Open("site");
  SiteOptions site;
  site.seed = static_cast<std::uint32_t>(section.Integer("seed"));
  site.noise = section.Number("noise");
  site.blur = section.Number("blur");
  site.lighting = section.Number("lighting");
  site.flicker = section.Number("flicker");
  site.pace = section.Number("pace");
  site.lamp = section.Number("lamp");
  site.misplacement = section.Vector2("misplacement");
  Section motion = section.Open("motion");
  if (motion.present()) {
    site.motion.amplitude = motion.Vector2("amplitude");
    site.motion.period = motion.Number("period");
  }
  Section hand = section.Open("hand");
  if (hand.present()) {
    site.hand = {hand.Number("tilt"),   hand.Number("tremor"), hand.Number("exposure"),
                 hand.Number("shadow"), hand.Number("jitter"), hand.Number("lens")};
  }
  Section embryo = section.Open("embryo");
  if (embryo.present()) site.embryo = ReadEmbryo(embryo);
  return site;
}

std::vector<Eigen::Vector3d> ReadStudyContacts(Section& scene) {
  constexpr std::size_t kMaxContacts = 100;
  constexpr std::string_view kAccepted = "a list of 1 to 100 points [x, y, z] on the object";
  Section study = scene.Open("study");
  std::vector<Eigen::Vector3d> places;
  if (!study.Has("contacts")) return places;
  Section list = study.OpenList("contacts");
  if (!list.present()) return places;
  if (list.size() == 0 || list.size() > kMaxContacts) study.Refuse("contacts", kAccepted);
  for (std::size_t i = 0; i < list.size(); ++i) {
    places.push_back(list.Vector3(std::to_string(i)));
  }
  return places;
}

}  // namespace palpate
