#include "master/view/shape_picture.h"

#include <algorithm>
#include <array>

#include "master/view/shape_layers.h"
#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;
using Anchor = Svg::Anchor;

constexpr double kWidth = 960, kHeight = 640;       // [px], as all here
const Vector2d kCorner(140, 130), kRoom(460, 400);  // of the object; arrows stand around it
constexpr double kLegend = 750;
constexpr double kArrow = 130;        // the longest arrow at its scale's end
constexpr double kLeastForce = 0.05;  // that a scale ends with [N]
constexpr double kLeastShare = 1e-3;  // of the object's size, that a colour scale ends with [-]

constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 13px; background: #ffffff; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; font-size: 12px; }
.heading { fill: #1d2430; font-size: 18px; font-weight: 600; }
.finger-name { fill: #0b4ea2; font-size: 14px; font-weight: 600; }
text { paint-order: stroke; stroke: #ffffff; stroke-width: 3px; stroke-linejoin: round; }
.face { stroke-width: 0.6; stroke-linejoin: round; } .near { opacity: 0.76; }
.edge { fill: none; stroke: #1d2430; stroke-opacity: 0.16; stroke-width: 0.7; stroke-linejoin: round; }
.rest { stroke: #1d2430; stroke-opacity: 0.62; stroke-width: 1.3; stroke-dasharray: 6 4; }
.shaft { stroke: #0b4ea2; stroke-width: 6; } .head { fill: #0b4ea2; }
.halo { stroke: #ffffff; stroke-width: 10; fill: #ffffff; stroke-linejoin: round; }
.head.halo { stroke-width: 4; }
.through { stroke: #0b4ea2; stroke-opacity: 0.75; stroke-width: 3.5; stroke-dasharray: 5 4; }
.through-head { fill: #0b4ea2; fill-opacity: 0.6; }
.free { fill: #ffffff; stroke: #0b4ea2; stroke-width: 2; } .touch { fill: #0b4ea2; stroke: #ffffff; stroke-width: 2; }
.bar { stroke: #1d2430; stroke-width: 2; } .tick { stroke: #1d2430; stroke-width: 1; }
)";

bool IsPlanar(const MeshTopology& topology) {
  return !topology.lines.empty();
}

std::array<Vector3d, 2> BoxOf(const std::vector<Vector3d>& nodes) {
  if (nodes.empty()) return {Vector3d::Zero(), Vector3d::Zero()};
  std::array<Vector3d, 2> box{nodes.front(), nodes.front()};
  for (const Vector3d& node : nodes) box = {box[0].cwiseMin(node), box[1].cwiseMax(node)};
  return box;
}

Viewpoint ViewOf(const MeshTopology& topology, const std::vector<Vector3d>& homes) {
  const auto box = BoxOf(topology.surface.nodes);
  Vector3d across(0, 0, 0);
  if (homes.size() >= 2) across = homes[1] - homes[0];
  if (homes.size() == 1) across = homes[0] - (box[0] + box[1]) / 2;
  Viewpoint view = IsPlanar(topology) ? Viewpoint::Front() : Viewpoint::Across(across);
  view.Fit(topology.surface.nodes, kCorner, kRoom);
  return view;
}

std::vector<FingerMark> MarksOf(const ShapeMoment& moment) {
  std::vector<FingerMark> marks;
  for (const NamedFinger& finger : moment.fingers) {
    marks.push_back({finger, PlaceNow(finger.felt, *moment.mesh)});
  }
  return marks;
}

double LargestPress(const std::vector<FingerMark>& marks) {
  double largest = 0;
  for (const auto& mark : marks) largest = std::max(largest, PressOf(mark.finger.felt).norm());
  return largest;
}

// The corner of the frame S, as it is turned in the picture.
void PaintAxes(const Viewpoint& view, Svg* drawing) {
  constexpr double kLength = 34;
  const Vector2d origin(60, kHeight - 60);
  for (const auto& [axis, name] :
       {std::pair(Vector3d(1, 0, 0), "x"), {Vector3d(0, 1, 0), "y"}, {Vector3d(0, 0, 1), "z"}}) {
    const Vector2d way = view.Direction(axis, kLength);
    if (way.norm() < 1) continue;
    drawing->Line(origin, origin + way, "tick");
    drawing->Text(origin + 1.3 * way + Vector2d(0, 4), name, "soft", Anchor::kMiddle);
  }
}

void PaintColours(double full, double top, Svg* drawing) {
  constexpr double kTall = 180, kWide = 20;
  constexpr int kSteps = 60, kTicks = 4;
  drawing->Text({kLegend, top}, "displacement [mm]", "ink");
  const Vector2d corner(kLegend, top + 16);
  for (int i = 0; i < kSteps; ++i) {
    const double y = corner.y() + kTall * (1 - (i + 1.0) / kSteps), h = kTall / kSteps;
    const std::array<Vector2d, 4> cell{Vector2d(corner.x(), y), Vector2d(corner.x() + kWide, y),
                                       Vector2d(corner.x() + kWide, y + h),
                                       Vector2d(corner.x(), y + h)};
    drawing->Face(cell, ColourOf((i + 0.5) / kSteps));
  }
  for (int i = 0; i <= kTicks; ++i) {
    const double y = corner.y() + kTall * (1 - static_cast<double>(i) / kTicks);
    drawing->Line({corner.x() + kWide, y}, {corner.x() + kWide + 5, y}, "tick");
    drawing->Text({corner.x() + kWide + 10, y + 4}, Readable(1e3 * full * i / kTicks), "soft");
  }
}

void PaintScales(const Viewpoint& view, double full_force, double top, Svg* drawing) {
  PaintArrow({kLegend, top}, {kLegend + kArrow, top}, drawing);
  drawing->Text({kLegend + kArrow + 12, top + 5}, Readable(full_force) + " N", "ink");
  drawing->Text({kLegend, top + 25}, "force on the object", "soft");
  drawing->Line({kLegend, top + 60}, {kLegend + kArrow, top + 60}, "rest");
  drawing->Text({kLegend + kArrow + 12, top + 65}, "at rest", "ink");
  const double bar = RoundedUp(kArrow / view.scale() / 2, 1e-12);  // half of the room or more
  drawing->Line({kLegend, top + 100}, {kLegend + bar * view.scale(), top + 100}, "bar");
  for (const double x : {0.0, bar * view.scale()}) {
    drawing->Line({kLegend + x, top + 95}, {kLegend + x, top + 105}, "bar");
  }
  drawing->Text({kLegend, top + 124}, Readable(1e3 * bar) + " mm", "soft");
}

void PaintTitle(const ShapeMoment& moment, Svg* drawing) {
  drawing->Text({30, 40}, moment.scene + Formatted(" at %.1f s", moment.t), "heading");
  std::string words = "moved by up to " + Readable(1e3 * moment.mesh->LargestDeflection()) + " mm";
  if (moment.mesh->validity != Validity::kValid) {
    words += " (" + std::string(ToString(moment.mesh->validity)) + ")";
  }
  drawing->Text({30, 62}, words, "soft");
}

}  // namespace

Vector3d PlaceNow(const FingerState& finger, const RemoteMesh& mesh) {
  const Vector3d place = finger.p_S_contact.cast<double>();
  const SurfaceMesh& rest = mesh.topology->surface;
  if (!finger.in_contact || rest.triangles.empty()) return place;
  const auto found = FindPlace(rest, place);
  if (!found || found->triangle < 0) return place;
  Vector3d moved(0, 0, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto node =
        static_cast<std::size_t>(rest.triangles[static_cast<std::size_t>(found->triangle)][i]);
    moved +=
        found->weights[static_cast<Eigen::Index>(i)] * (mesh.positions[node] - rest.nodes[node]);
  }
  return place + moved;
}

std::string DrawShape(const ShapeMoment& moment) {
  const RemoteMesh& mesh = *moment.mesh;
  const auto box = BoxOf(mesh.topology->surface.nodes);
  const double size = std::max((box[1] - box[0]).norm(), 1e-12);
  const double full = RoundedUp(mesh.LargestDeflection(), kLeastShare * size);
  const Viewpoint view = ViewOf(*mesh.topology, moment.homes);
  const auto marks = MarksOf(moment);
  const double full_force = RoundedUp(LargestPress(marks), kLeastForce);

  Svg drawing(kWidth, kHeight, moment.scene, kStyle);
  const std::array<Vector2d, 4> paper{Vector2d(0, 0), Vector2d(kWidth, 0),
                                      Vector2d(kWidth, kHeight), Vector2d(0, kHeight)};
  drawing.Polygon(paper, "paper");
  PaintFingers(marks, view, kArrow / full_force, Layer::kBehind, &drawing);
  PaintSurface(mesh, view, full, &drawing);
  PaintRest(*mesh.topology, view, &drawing);
  PaintFingers(marks, view, kArrow / full_force, Layer::kBefore, &drawing);
  PaintAxes(view, &drawing);
  PaintColours(full, 120, &drawing);
  PaintScales(view, full_force, 380, &drawing);
  PaintTitle(moment, &drawing);
  return drawing.Document();
}

}  // namespace palpate
