#include "slave/study/reachable_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"

namespace palpate::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFreeWidth = 2;   // free width required, relative to the tool's width
constexpr double kStraight = 0.9;  // smallest cosine between normals under the tool
// Largest distance from the centre, relative to a membrane's radius.
constexpr double kWithin = 0.6;

// Returns the piece that contains the fraction `share` of the cumulative size, and the fraction
// within that piece.
std::pair<std::size_t, double> PieceAt(const std::vector<double>& sizes, double share) {
  double rest = share * std::accumulate(sizes.begin(), sizes.end(), 0.0);
  std::size_t at = 0;
  while (at + 1 < sizes.size() && rest >= sizes[at]) rest -= sizes[at++];
  return {at, rest / sizes[at]};
}

std::vector<Vector3d> PlacesOnOutline(const Scene& scene, double width,
                                      const std::vector<double>& shares) {
  constexpr int kPieces = 3989;  // prime, so that it is not commensurate with any mesh
  Scene fine = scene;
  if (!HoldsByNumber(scene)) fine.model.elements = kPieces;
  const BoundaryMesh mesh = MeshOutline(fine, std::nullopt);
  const auto held = FixedElementDofs(fine, mesh);
  std::vector<Vector3d> middles;
  std::vector<double> lengths;
  for (int i = 0; i < mesh.size(); ++i) {
    const BoundaryElement& middle = mesh.elements[Index(i)];
    const auto carries = [&](int k) {
      return !held[Index(k)][0] && !held[Index(k)][1] &&
             mesh.elements[Index(k)].normal().dot(middle.normal()) > kStraight;
    };
    if (!std::ranges::all_of(PatchElements(mesh, i, middle.midpoint(), kFreeWidth * width),
                             carries))
      continue;
    const Vector2d p = middle.midpoint();
    middles.emplace_back(p.x(), p.y(), 0);
    lengths.push_back(middle.length());
  }
  std::vector<Vector3d> places;
  for (const double share : shares) {
    if (!middles.empty()) places.push_back(middles[PieceAt(lengths, share).first]);
  }
  return places;
}

std::vector<double> AreasOf(const SurfaceMesh& skin) {
  std::vector<double> areas;
  for (int t = 0; t < static_cast<int>(skin.triangles.size()); ++t) areas.push_back(Area(skin, t));
  return areas;
}

// Fixed parts are known only at nodes, so the triangles must be small.
SurfaceMesh FineSkin(const Scene& scene, double width) {
  constexpr std::size_t kMaxTriangles = 6'000;
  SurfaceMesh skin = SurfaceOf(MeshObject(scene, std::nullopt));
  while (std::ranges::max(AreasOf(skin)) > 0.1 * width * width &&
         4 * skin.triangles.size() < kMaxTriangles) {
    skin = Refined(skin);
  }
  return skin;
}

double Fraction(double x) {
  return x - std::floor(x);
}

// Returns a point anywhere on a triangle; centres would have the same position in every mesh of a
// kind.
Vector3d OnFacet(const SurfaceMesh& skin, const std::vector<double>& areas, double share) {
  constexpr double kStripes = 100 * std::numbers::phi;
  const auto [at, within] = PieceAt(areas, share);
  const double a = std::sqrt(within), b = Fraction(kStripes * within);
  const auto& corners = skin.triangles[at];
  return (1 - a) * skin.nodes[Index(corners[0])] + a * (1 - b) * skin.nodes[Index(corners[1])] +
         a * b * skin.nodes[Index(corners[2])];
}

// Moves shares where the tool finds no support to positions all over the surface: positions beside
// a gap would otherwise get too many presses.
std::vector<Vector3d> PlacesOnSkin(const Scene& scene, double width,
                                   const std::vector<double>& shares) {
  constexpr int kMaxMissed = 300;
  constexpr double kOnObject = 0.97;  // smallest supported part of the tool's face
  const SurfaceMesh skin = FineSkin(scene, width);
  const HeldNodes held = FixedNodeDofs(scene, skin.nodes);
  const double face = 0.25 * std::numbers::pi * width * width;
  const auto near_held = [&](const Vector3d& p_O) {
    for (std::size_t i = 0; i < held.size(); ++i) {
      const bool holds = held[i][0] || held[i][1] || held[i][2];
      if (holds && (skin.nodes[i] - p_O).norm() < 0.5 * kFreeWidth * width) return true;
    }
    return false;
  };
  const auto carries = [&](const Vector3d& p_O) {
    if (near_held(p_O)) return false;
    const auto place = FindPlace(skin, p_O);
    return place && PatchAt(skin, *place, p_O, width).disc.area >= kOnObject * face;
  };
  const std::vector<double> areas = AreasOf(skin);
  std::vector<Vector3d> places;
  int missed = 0;  // consecutive misses
  for (double share : shares) {
    Vector3d p_O = OnFacet(skin, areas, share);
    while (missed < kMaxMissed && !carries(p_O)) {
      ++missed;
      share = Fraction(share + std::numbers::phi);
      p_O = OnFacet(skin, areas, share);
    }
    if (missed == kMaxMissed) break;
    missed = 0;
    places.push_back(p_O);
  }
  return places;
}

std::vector<Vector3d> PlacesOnMembrane(double radius, const std::vector<double>& shares) {
  constexpr double kTurns = 7;  // turns of the spiral while the radius grows
  std::vector<Vector3d> places;
  for (const double share : shares) {
    const double r = kWithin * radius * std::sqrt(share),
                 angle = 2 * std::numbers::pi * kTurns * share;
    places.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
  }
  return places;
}

// Returns whether a volume's reference at several places takes some seconds, not minutes; boxes are
// always graded quickly.
bool IsQuicklyGraded(const Scene& scene) {
  constexpr std::size_t kQuickTets = 3'000;
  if (HoldsByNumber(scene)) return false;
  if (std::holds_alternative<BoxGeometry>(scene.object.geometry)) return true;
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  return solid != nullptr && solid->tets.size() <= kQuickTets;
}

// Moves the contacts to few radii, because the solid for camera measurements takes a second for
// each radius.
void KeepToFewRadii(const Geometry& geometry, std::vector<Vector3d>* places) {
  const auto* membrane = std::get_if<MembraneGeometry>(&geometry);
  if (membrane == nullptr) return;
  constexpr double kRaster = 2.0 / 13;  // distance between radii, relative to the membrane's radius
  const double raster = kRaster * membrane->radius;
  for (Vector3d& p_O : *places) {
    const double radius = p_O.norm();
    if (radius > 0) p_O *= raster * std::round(radius / raster) / radius;
  }
}

}  // namespace

std::vector<Vector3d> ReachablePlaces(const Scene& scene, double width,
                                      const std::vector<double>& shares) {
  const Geometry& geometry = scene.object.geometry;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&geometry)) {
    return PlacesOnMembrane(membrane->radius, shares);
  }
  return IsPlanar(geometry) ? PlacesOnOutline(scene, width, shares)
                            : PlacesOnSkin(scene, width, shares);
}

std::vector<double> SpreadShares(int count) {
  std::vector<double> shares;
  for (int i = 0; i < count; ++i) {
    const double turns = (i + 0.5) * std::numbers::phi;
    shares.push_back((i + Fraction(turns)) / count);
  }
  return shares;
}

std::vector<Vector3d> PlacesToStudy(const Scene& scene) {
  // At least 29 are needed for a 95 % bound of the 90th percentile (BeyondBound).
  constexpr int kOnOutline = 128, kMinOnSurface = 29;
  const bool has_own = !scene.study_contacts.empty() || !scene.tool;
  if (has_own) return {};
  const auto is_slow = [&] { return IsTouchedRound(scene) || !IsQuicklyGraded(scene); };
  if (IsVolume(scene.object.geometry) && is_slow()) return {};
  const Geometry& geometry = scene.object.geometry;
  const bool is_quick = IsPlanar(geometry) && !std::holds_alternative<DiscGeometry>(geometry);
  const int count = is_quick ? kOnOutline : kMinOnSurface;
  auto places = ReachablePlaces(scene, scene.tool->width, SpreadShares(count));
  if (HasStereoOrDepth(scene.sense)) KeepToFewRadii(geometry, &places);
  return places;
}

}  // namespace palpate::study
