// `sense.points`: points that two cameras or depth images track on the object (paper C, 3.2).
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "slave/scene/contour_file.h"
#include "slave/scene/sections.h"

namespace palpate {
namespace {

using Track = PointTracking::Track;
using Eigen::Vector2d;

constexpr int kMinDots = 4, kMaxDots = 400;  // of a lattice: three would be a line
constexpr int kMaxWindows = 10'000;
constexpr double kRadiusPerSpacing = 0.2;  // radius of a dot: 2 mm for a spacing of 10 mm

const MembraneGeometry* MembraneOf(const Object& object) {
  return std::get_if<MembraneGeometry>(&object.geometry);
}

Track ReadTrack(Section& points, const Object& object, const StereoOrDepth& cameras) {
  using Choice = Section::Choice<Track>;
  const auto* pair = std::get_if<StereoCameras>(&cameras);
  const bool is_simulated = pair != nullptr && pair->source == StereoCameras::Source::kSimulated;
  const bool has_array = MembraneOf(object) != nullptr || points.Has("layout");
  const Track fallback = pair == nullptr ? Track::kSurface
                         : has_array     ? Track::kDots
                                         : Track::kTexture;
  std::array choices{Choice{"dots", Track::kDots}, Choice{"texture", Track::kTexture},
                     Choice{"surface", Track::kSurface}};
  std::ranges::rotate(choices, choices.begin() + static_cast<std::ptrdiff_t>(fallback));
  const Track track = points.OneOfTable<Track>("track", choices);
  if (pair == nullptr && track != Track::kSurface) {
    points.Refuse("track", "surface with depth images: they show neither dots nor texture");
  } else if (pair != nullptr && track == Track::kSurface) {
    points.Refuse("track", "dots or texture with a stereo pair: surface needs depth images");
  } else if (track == Track::kDots && !has_array) {
    points.Refuse("track",
                  "texture, or dots with a `layout`: only a membrane has a default layout");
  } else if (is_simulated && track == Track::kDots && MembraneOf(object) == nullptr) {
    points.Refuse("track", "texture: a simulated pair shows dots on a membrane only");
  }
  return track;
}

double NearestNeighbours(const std::vector<Vector2d>& places) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) nearest = std::min(nearest, (places[i] - places[k]).norm());
  }
  return nearest;
}

// Returns whether `count` points of a lattice, centred on a point, an edge or a cell, are within
// `reach`.
bool LatticeFits(int count, const Vector2d& spacing, double reach) {
  for (const Vector2d& centre :
       {Vector2d(0, 0), Vector2d(0.5, 0.5), Vector2d(0.5, 0), Vector2d(0, 0.5)}) {
    int inside = 0;
    for (int j = -count; j <= count; ++j) {
      for (int i = -count; i <= count; ++i) {
        inside += (Vector2d(i, j) + centre).cwiseProduct(spacing).norm() <= reach ? 1 : 0;
      }
    }
    if (inside >= count) return true;
  }
  return false;
}

// Returns the spacing of paper C, scaled to other membranes and counts.
Vector2d DefaultSpacing(const Object& object, int count) {
  const PointTracking paper;
  constexpr double kRadius = 0.039;  // of paper C's membrane [m]
  // Margin, because more dots are less evenly distributed and must not be too near the rim.
  constexpr double kMargin = 0.85;
  const auto* membrane = MembraneOf(object);
  const double size = membrane != nullptr && membrane->radius > 0 ? membrane->radius / kRadius : 1;
  const double density = count > paper.count ? kMargin * std::sqrt(1.0 * paper.count / count) : 1;
  return size * density * paper.spacing;
}

// A file that says where the dots are. After a mistake: empty.
std::vector<Vector2d> ReadLayout(Section& points, const SceneContext& context,
                                 PointTracking* tracking) {
  for (const char* key : {"count", "spacing"}) {
    if (points.Has(key)) points.Refuse(key, "nothing with `layout`, whose file defines it");
  }
  tracking->layout = ReadExistingFile(points, "layout", context);
  std::error_code error;
  if (!std::filesystem::is_regular_file(tracking->layout, error)) return {};
  try {
    auto places = ReadContourFile(tracking->layout);
    tracking->count = static_cast<int>(places.size());
    if (places.size() <= kMaxDots) return places;
    points.Refuse("layout", "a CSV file of 3 to 400 positions x,y [m]");
  } catch (const std::invalid_argument& mistake) {
    points.Refuse("layout", std::string("a CSV file of positions x,y [m]; ") + mistake.what());
  }
  return {};
}

// The distance between neighbours; 0 after a mistake.
double ReadArray(Section& points, const Object& object, PointTracking* tracking) {
  const std::size_t before = points.mistakes()->count();
  tracking->count =
      points.IntegerWithin("count", {Dimension::kNumber, kMinDots, kMaxDots, ""}, tracking->count);
  tracking->spacing = points.Vector2("spacing", DefaultSpacing(object, tracking->count));
  if (points.mistakes()->count() > before) return 0;
  if (tracking->spacing.maxCoeff() >= 1e3 * tracking->spacing.minCoeff()) {
    points.Refuse("spacing", "two lengths, less than 1000 to 1");
    return 0;
  }
  return tracking->spacing.minCoeff();
}

void ReadDots(Section& points, const SceneContext& context, const Object& object,
              PointTracking* tracking) {
  const auto* membrane = MembraneOf(object);
  std::vector<Vector2d> places;
  double apart = 0;
  if (points.Has("layout")) {
    places = ReadLayout(points, context, tracking);
    apart = places.empty() ? 0 : NearestNeighbours(places);
  } else {
    apart = ReadArray(points, object, tracking);
  }
  const double usual = apart > 0 ? kRadiusPerSpacing * apart : tracking->dot_radius;
  const std::size_t before = points.mistakes()->count();
  const double radius = points.Number("radius", usual);
  tracking->dot_radius = radius;
  if (apart == 0 || points.mistakes()->count() > before) return;
  const bool has_layout = !places.empty();
  if (2 * radius >= apart) {
    points.Refuse(points.Has("radius") ? "radius"
                  : has_layout         ? "layout"
                                       : "spacing",
                  "dots that do not touch each other: 2 radius < distance");
  } else if (membrane != nullptr && membrane->radius > 0) {
    const double reach = membrane->radius - radius;
    const bool fits =
        has_layout ? std::ranges::all_of(places, [&](const auto& p) { return p.norm() <= reach; })
                   : LatticeFits(tracking->count, tracking->spacing, reach);
    if (fits) return;
    points.Refuse(has_layout              ? "layout"
                  : points.Has("spacing") ? "spacing"
                                          : "radius",
                  "dots that all fit inside the membrane's rim");
  }
}

void ReadWindows(Section& points, const std::array<int, 2>& size, PointTracking* tracking) {
  tracking->window = points.Integer("window");
  if (tracking->window % 2 == 0) points.Refuse("window", "an odd number of pixels, 9 to 255");
  if (!points.Has("at")) {
    tracking->count =
        points.IntegerWithin("count", {Dimension::kNumber, 1, kMaxWindows, ""}, tracking->count);
    return;
  }
  if (points.Has("count")) points.Refuse("count", "nothing with `at`, which lists each window");
  const std::size_t before = points.mistakes()->count();
  tracking->at = points.Points("at");
  tracking->count = static_cast<int>(tracking->at.size());
  if (tracking->at.empty() || tracking->at.size() > kMaxWindows) {
    points.Refuse("at", "1 to 10000 positions [u, v] in the first left image");
  }
  if (size[0] == 0 || size[1] == 0 || points.mistakes()->count() > before) return;
  const double half = 0.5 * (tracking->window - 1);
  const auto fits = [&](const Vector2d& p) {
    return p.minCoeff() >= half && p.x() <= size[0] - 1 - half && p.y() <= size[1] - 1 - half;
  };
  if (std::ranges::all_of(tracking->at, fits)) return;
  points.Refuse("at", "positions whose windows lie inside the image of " + std::to_string(size[0]) +
                          " x " + std::to_string(size[1]) + " px");
}

}  // namespace

PointTracking ReadPoints(Section& sense, const SenseSetting& setting,
                         const StereoOrDepth& cameras) {
  const Object& object = setting.object;
  Section points = sense.Open("points");
  PointTracking tracking;
  tracking.track = ReadTrack(points, object, cameras);
  if (tracking.track == Track::kDots) ReadDots(points, setting.context, object, &tracking);
  if (tracking.track == Track::kTexture) {
    const auto* pair = std::get_if<StereoCameras>(&cameras);
    ReadWindows(points, pair != nullptr ? pair->size : std::array{0, 0}, &tracking);
  }
  if (tracking.track != Track::kSurface) tracking.sigma = points.Number("sigma");
  return tracking;
}

}  // namespace palpate
