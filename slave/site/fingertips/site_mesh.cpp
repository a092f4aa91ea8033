#include "slave/site/fingertips/site_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "slave/mechanics/object_mesh.h"

namespace palpate::site {
namespace {

using Eigen::Vector3d;

constexpr double kSame = 1e-3;  // edges: focuses nearer than this are one
constexpr int kSamples = 400;   // of an integral along one axis

double EdgeAt(double t, std::span<const double> focuses, const SiteResolution& resolution) {
  double nearest = std::abs(t - focuses.front());
  for (const double focus : focuses) nearest = std::min(nearest, std::abs(t - focus));
  return resolution.edge + resolution.growth * std::max(nearest - resolution.fine_reach, 0.0);
}

// A stretch between two places that must be met, and how many cells its edges ask for up to each
// of its samples.
struct Stretch {
  double from = 0, to = 0;
  std::array<double, kSamples + 1> asked{};

  Stretch(double begin, double end, std::span<const double> focuses,
          const SiteResolution& resolution)
      : from(begin), to(end) {
    for (std::size_t i = 0; i < kSamples; ++i) {
      const double middle = from + (static_cast<double>(i) + 0.5) * step();
      asked[i + 1] = asked[i] + step() / EdgeAt(middle, focuses, resolution);
    }
  }
  [[nodiscard]] double step() const { return (to - from) / kSamples; }

  // Appends the points after `from` up to `to`.
  void Divide(int cells, std::vector<double>* points) const {
    std::size_t sample = 0;
    for (int i = 1; i < cells; ++i) {
      const double wanted = asked.back() * i / cells;
      while (asked[sample + 1] < wanted) ++sample;
      const double part = (wanted - asked[sample]) / (asked[sample + 1] - asked[sample]);
      points->push_back(from + (static_cast<double>(sample) + part) * step());
    }
    points->push_back(to);
  }
};

// One cell each, and the others one by one where cells are largest for what is asked.
std::vector<int> ShareOut(const std::vector<Stretch>& stretches, int cells) {
  std::vector<int> shares(stretches.size(), 1);
  for (int left = cells - static_cast<int>(stretches.size()); left > 0; --left) {
    std::size_t neediest = 0;
    const auto need = [&](std::size_t i) { return stretches[i].asked.back() / shares[i]; };
    for (std::size_t i = 1; i < stretches.size(); ++i) {
      if (need(i) > need(neediest)) neediest = i;
    }
    ++shares[neediest];
  }
  return shares;
}

}  // namespace

std::vector<double> GradedAxis(const AxisWishes& axis, const SiteResolution& resolution,
                               int cells) {
  std::vector<double> focuses = axis.focuses;
  if (focuses.empty()) focuses.push_back(0.5 * axis.length);
  for (double& focus : focuses) focus = std::clamp(focus, 0.0, axis.length);
  std::vector<double> met = focuses;
  met.insert(met.end(), axis.others.begin(), axis.others.end());
  met.push_back(axis.length);
  std::ranges::sort(met);
  std::vector<Stretch> stretches;
  double reached = 0;
  for (const double place : met) {
    const bool is_end = place >= axis.length;
    const double same = is_end ? 0 : kSame * resolution.edge;
    if (!(place - reached > same) || (!is_end && axis.length - place <= same)) continue;
    stretches.emplace_back(reached, std::min(place, axis.length), focuses, resolution);
    reached = stretches.back().to;
  }
  double asked = 0;
  for (const Stretch& stretch : stretches) asked += stretch.asked.back();
  const auto shares = ShareOut(stretches, cells > 0 ? cells : static_cast<int>(std::ceil(asked)));
  std::vector<double> points{0};
  for (std::size_t i = 0; i < stretches.size(); ++i) stretches[i].Divide(shares[i], &points);
  return points;
}

SolidMesh MeshGradedBox(const std::array<std::vector<double>, 3>& axes) {
  std::array<int, 3> cells{};
  for (std::size_t a = 0; a < 3; ++a) cells[a] = static_cast<int>(axes[a].size()) - 1;
  SolidMesh mesh = MeshBox(Vector3d(cells[0], cells[1], cells[2]), cells);
  for (auto& p : mesh.nodes) {
    for (int a = 0; a < 3; ++a) {
      p[a] = axes[static_cast<std::size_t>(a)][static_cast<std::size_t>(std::lround(p[a]))];
    }
  }
  return mesh;
}

SolidMesh OwnMesh(const Geometry& geometry) {
  Scene scene;
  scene.object.geometry = geometry;
  ObjectMesh own = MeshObject(scene, std::nullopt);
  if (auto* solid = std::get_if<SolidMesh>(&own)) return std::move(*solid);
  throw std::invalid_argument(
      "object.geometry: accepted by a site with fingertips is a volume: box or mesh");
}

SolidMesh RefinedWithin(SolidMesh mesh, std::size_t most_tets) {
  for (int i = 0; i < 2 && 8 * mesh.tets.size() <= most_tets; ++i) mesh = Refined(mesh);
  return mesh;
}

}  // namespace palpate::site
