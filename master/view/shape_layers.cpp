#include "master/view/shape_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

const double kSharp = std::cos(std::numbers::pi / 6);

bool IsDrawn(const SurfaceMesh& surface, const Viewpoint& view, const std::vector<int>& faces) {
  if (faces.size() != 2) return true;
  const Eigen::Vector3d one = Normal(surface, faces[0]), other = Normal(surface, faces[1]);
  const bool seen = view.Nearness(one) > 0, other_seen = view.Nearness(other) > 0;
  return seen != other_seen || (seen && one.dot(other) < kSharp);
}

constexpr std::size_t kMostFaces = 5000;  // that a picture is painted with, where there is a choice
constexpr int kMostParts = 6;             // of a triangle's edge
constexpr double kDark = 0.80;            // light on a face that looks away from the lamp

// Brightness of a face with `normal`, as seen by `view`: a lamp over the viewer's left shoulder.
double LightOn(const Eigen::Vector3d& normal, const Viewpoint& view) {
  const Eigen::Vector2d across = view.Direction(normal, 1);
  const double cosine = 0.35 * -across.x() + 0.62 * -across.y() + 0.70 * view.Nearness(normal);
  return kDark + (1 - kDark) * std::clamp(cosine, 0.0, 1.0);
}

struct Corner {
  Eigen::Vector2d at;  // [px]
  double share;        // of the colour scale [-]
};

using Face = std::array<Corner, 3>;

Corner Between(const Face& face, double u, double v) {
  const double w = 1 - u - v;
  return {w * face[0].at + u * face[1].at + v * face[2].at,
          w * face[0].share + u * face[1].share + v * face[2].share};
}

void Fill(const Corner& a, const Corner& b, const Corner& c, double light, Svg* drawing) {
  const std::array<Eigen::Vector2d, 3> corners{a.at, b.at, c.at};
  drawing->Face(corners, ColourOf((a.share + b.share + c.share) / 3, light));
}

// In `parts` x `parts` smaller triangles.
void Fill(const Face& face, double light, int parts, Svg* drawing) {
  const double h = 1.0 / parts;
  for (int i = 0; i < parts; ++i) {
    for (int j = 0; i + j < parts; ++j) {
      const Corner b = Between(face, (i + 1) * h, j * h), c = Between(face, i * h, (j + 1) * h);
      Fill(Between(face, i * h, j * h), b, c, light, drawing);
      if (i + j + 1 < parts) Fill(Between(face, (i + 1) * h, (j + 1) * h), c, b, light, drawing);
    }
  }
}

std::vector<double> Shares(const RemoteMesh& mesh, double full) {
  std::vector<double> shares(mesh.positions.size());
  for (std::size_t i = 0; i < shares.size(); ++i) {
    shares[i] = (mesh.positions[i] - mesh.topology->surface.nodes[i]).norm() / full;
  }
  return shares;
}

// A triangle as it is seen.
struct SeenTriangle {
  Face face;
  double light = 1, nearness = 0;
  bool looks_away =
      false;  // from the viewer: an open surface's other side, or hidden behind others
};

SeenTriangle Project(const RemoteMesh& mesh, const std::array<int, 3>& triangle,
                     const Viewpoint& view, const std::vector<double>& shares) {
  SeenTriangle seen;
  std::array<Eigen::Vector3d, 3> p;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto node = static_cast<std::size_t>(triangle[i]);
    p[i] = mesh.positions[node];
    seen.face[i] = {view.ToPicture(p[i]), shares[node]};
    seen.nearness += view.Nearness(p[i]);
  }
  const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).stableNormalized();
  seen.looks_away = view.Nearness(normal) < 0;
  seen.light = LightOn(seen.looks_away ? Eigen::Vector3d(-normal) : normal, view);
  return seen;
}

// From far to near: all that look away, then all others.
std::vector<SeenTriangle> FarFirst(const RemoteMesh& mesh, const Viewpoint& view,
                                   const std::vector<double>& shares) {
  std::vector<SeenTriangle> triangles;
  for (const auto& triangle : mesh.topology->surface.triangles) {
    triangles.push_back(Project(mesh, triangle, view, shares));
  }
  std::sort(triangles.begin(), triangles.end(), [](const SeenTriangle& a, const SeenTriangle& b) {
    return a.looks_away != b.looks_away ? a.looks_away : a.nearness < b.nearness;
  });
  return triangles;
}

void PaintTriangles(std::span<const SeenTriangle> triangles, int parts, Svg* drawing) {
  for (const auto& [face, light, nearness, looks_away] : triangles) {
    Fill(face, light, parts, drawing);
    if (looks_away) continue;
    const std::array<Eigen::Vector2d, 3> corners{face[0].at, face[1].at, face[2].at};
    drawing->Polygon(corners, "edge");
  }
}

void PaintOutline(const RemoteMesh& mesh, const Viewpoint& view, const std::vector<double>& shares,
                  Svg* drawing) {
  constexpr double kHalfWidth = 3;  // [px]
  for (const auto& line : mesh.topology->lines) {
    const auto a = static_cast<std::size_t>(line[0]), b = static_cast<std::size_t>(line[1]);
    const Eigen::Vector2d from = view.ToPicture(mesh.positions[a]);
    const Eigen::Vector2d to = view.ToPicture(mesh.positions[b]);
    const Eigen::Vector2d along = (to - from).stableNormalized();
    const Eigen::Vector2d side = kHalfWidth * Eigen::Vector2d(-along.y(), along.x());
    const std::array<Eigen::Vector2d, 4> band{from - side, to - side, to + side, from + side};
    drawing->Face(band, ColourOf((shares[a] + shares[b]) / 2));
  }
}

constexpr double kHead = 18, kHalfHead = 8;  // of an arrow [px]
constexpr double kShortest = 2;              // what is shorter points nowhere [px]
constexpr double kRing = 7;                  // radius of a free finger [px]
constexpr double kGap = 10;                  // between an arrow and its label [px]

// Head, then shaft, of an arrow; the head shrinks with short ones.
struct Arrow {
  Eigen::Vector2d tail, neck, head, side;

  Arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to) : tail(from), head(to) {
    const Eigen::Vector2d along = (to - from).stableNormalized();
    const double size = std::min(1.0, (to - from).norm() / (1.5 * kHead));
    neck = to - size * kHead * along;
    side = size * kHalfHead * Eigen::Vector2d(-along.y(), along.x());
  }
  [[nodiscard]] std::array<Eigen::Vector2d, 3> Point() const {
    return {head, neck + side, neck - side};
  }
};

std::string Words(Validity validity) {
  std::string words(ToString(validity));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

bool ComesFromBehind(const FingerMark& mark, const Viewpoint& view) {
  return view.Nearness(PressOf(mark.finger.felt)) > 0;
}

// Beside `at`, away from the arrow that starts there along `outward`.
void PaintLabel(const NamedFinger& finger, const Eigen::Vector2d& at,
                const Eigen::Vector2d& outward, Svg* drawing) {
  constexpr double kLine = 17;  // [px]
  const Eigen::Vector2d away = outward.stableNormalized();
  const auto anchor = away.x() < -0.4  ? Svg::Anchor::kEnd
                      : away.x() > 0.4 ? Svg::Anchor::kStart
                                       : Svg::Anchor::kMiddle;
  const double rise = away.y() < 0 ? -kLine : 4;
  const Eigen::Vector2d first = at + kGap * away + Eigen::Vector2d(0, rise + 4);
  drawing->Text(first, finger.name, "finger-name", anchor);
  drawing->Text(first + Eigen::Vector2d(0, kLine), InWords(finger.felt), "ink", anchor);
}

void PaintFinger(const FingerMark& mark, const Viewpoint& view, double length, Layer layer,
                 Svg* drawing) {
  const Eigen::Vector2d head = view.ToPicture(mark.place);
  const Eigen::Vector2d way = view.Direction(PressOf(mark.finger.felt), length);
  const bool behind = ComesFromBehind(mark, view);
  if (layer == Layer::kBehind) {
    if (behind && way.norm() > kShortest) PaintArrow(head - way, head, drawing);
    return;
  }
  if (way.norm() <= kShortest) {
    drawing->Circle(head, kRing, mark.finger.felt.in_contact ? "touch" : "free");
    return PaintLabel(mark.finger, head + Eigen::Vector2d(kRing, 0), {1, -0.2}, drawing);
  }
  if (behind) {
    const Arrow arrow(head - way, head);
    drawing->Line(arrow.tail, arrow.neck, "through");
    drawing->Polygon(arrow.Point(), "through-head");
  } else {
    PaintArrow(head - way, head, drawing);
  }
  PaintLabel(mark.finger, head - way, -way, drawing);
}

constexpr double kAside = 20 * std::numbers::pi / 180;      // off the side view
constexpr double kElevation = 24 * std::numbers::pi / 180;  // above the horizon
constexpr double kUpright = 0.05;                           // horizontal share of a direction [-]

using Colour = std::array<double, 3>;

// Pale grey over orange to dark purple: darker is larger, also for colour-blind viewers.
constexpr std::array<Colour, 5> kStops{{
    {236, 239, 243},
    {250, 214, 145},
    {242, 142, 75},
    {205, 62, 78},
    {112, 28, 92},
}};

}  // namespace

std::vector<std::array<int, 2>> VisibleOutline(const SurfaceMesh& surface, const Viewpoint& view) {
  std::map<std::array<int, 2>, std::vector<int>> faces_of;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& triangle = surface.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      faces_of[{low, high}].push_back(static_cast<int>(t));
    }
  }
  std::vector<std::array<int, 2>> edges;
  for (const auto& [edge, faces] : faces_of) {
    if (IsDrawn(surface, view, faces)) edges.push_back(edge);
  }
  return edges;
}

void PaintSurface(const RemoteMesh& mesh, const Viewpoint& view, double full, Svg* drawing) {
  const std::vector<double> shares = Shares(mesh, full);
  const std::vector<SeenTriangle> triangles = FarFirst(mesh, view, shares);
  const double room = static_cast<double>(kMostFaces) / static_cast<double>(triangles.size() + 1);
  const int parts = std::clamp(static_cast<int>(std::sqrt(room)), 1, kMostParts);
  const auto near = std::partition_point(triangles.begin(), triangles.end(),
                                         [](const SeenTriangle& t) { return t.looks_away; });
  PaintTriangles({triangles.begin(), near}, parts, drawing);
  drawing->BeginGroup("near");
  PaintTriangles({near, triangles.end()}, parts, drawing);
  drawing->EndGroup();
  PaintOutline(mesh, view, shares, drawing);
}

void PaintRest(const MeshTopology& topology, const Viewpoint& view, Svg* drawing) {
  auto edges = VisibleOutline(topology.surface, view);
  edges.insert(edges.end(), topology.lines.begin(), topology.lines.end());
  const auto at = [&](int node) {
    return view.ToPicture(topology.surface.nodes[static_cast<std::size_t>(node)]);
  };
  for (const auto& edge : edges) drawing->Line(at(edge[0]), at(edge[1]), "rest");
}

Eigen::Vector3d PressOf(const FingerState& finger) {
  const bool known = finger.in_contact && IsForceKnown(finger);
  return known ? Eigen::Vector3d(-finger.force->cast<double>()) : Eigen::Vector3d(0, 0, 0);
}

std::string InWords(const FingerState& finger) {
  if (!IsForceKnown(finger)) {
    return "force unknown (" + Words(finger.validity) + ")";
  }
  if (!finger.in_contact) return "free";
  std::string words = Readable(finger.force->cast<double>().norm()) + " N";
  if (finger.validity != Validity::kValid) words += ", " + Words(finger.validity);
  return words;
}

void PaintFingers(const std::vector<FingerMark>& marks, const Viewpoint& view, double length,
                  Layer layer, Svg* drawing) {
  for (const FingerMark& mark : marks) PaintFinger(mark, view, length, layer, drawing);
}

void PaintArrow(const Eigen::Vector2d& tail, const Eigen::Vector2d& head, Svg* drawing) {
  const Arrow arrow(tail, head);
  const auto point = arrow.Point();
  drawing->Line(arrow.tail, arrow.neck, "halo");
  drawing->Polygon(point, "halo");
  drawing->Line(arrow.tail, arrow.neck, "shaft");
  drawing->Polygon(point, "head");
}

Viewpoint Viewpoint::Across(const Eigen::Vector3d& along) {
  const double flat = along.head<2>().norm();
  const bool lies = flat > kUpright * along.norm() && std::isfinite(along.norm());
  double azimuth = (lies ? std::atan2(along.y(), along.x()) : 0) + kAside;
  if (std::cos(azimuth) < 0) azimuth += std::numbers::pi;  // x runs to the right
  const Eigen::Vector3d right(std::cos(azimuth), std::sin(azimuth), 0);
  const Eigen::Vector3d away(-std::sin(azimuth), std::cos(azimuth), 0);
  const Eigen::Vector3d z(0, 0, 1);
  return {right, std::cos(kElevation) * z + std::sin(kElevation) * away,
          std::sin(kElevation) * z - std::cos(kElevation) * away};
}

Viewpoint Viewpoint::Front() {
  return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
}

void Viewpoint::Fit(std::span<const Eigen::Vector3d> points, const Eigen::Vector2d& corner,
                    const Eigen::Vector2d& size) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(kInf, kInf), high(-kInf, -kInf);
  for (const Eigen::Vector3d& point : points) {
    low = low.cwiseMin(Across2d(point));
    high = high.cwiseMax(Across2d(point));
  }
  if (points.empty()) low = high = {0, 0};
  const Eigen::Vector2d extent = high - low;
  const double scale = std::min(size.x() / extent.x(), size.y() / extent.y());
  scale_ = std::isfinite(scale) ? scale : 1;
  origin_ = corner + size / 2 - scale_ * (low + high) / 2;
}

double RoundedUp(double value, double floor) {
  if (!(value > floor)) value = floor;
  if (!std::isfinite(value)) value = 1e300;
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 4.0, 6.0, 8.0}) {
    if (value <= step * decade * (1 + 1e-9)) return step * decade;
  }
  return 10 * decade;
}

std::string ColourOf(double share, double light) {
  const double at = std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double rest = at - static_cast<double>(below);
  std::array<unsigned, 3> rgb{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double mixed = (1 - rest) * kStops[below][i] + rest * kStops[below + 1][i];
    rgb[i] = static_cast<unsigned>(std::lround(std::clamp(light, 0.0, 1.0) * mixed));
  }
  return Formatted("#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
}

std::string Readable(double value) {
  return Formatted("%.3g", value);
}

}  // namespace palpate
