#include "slave/site/fingertip/site_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
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

// Points after `from` up to `to`, as many and as spaced as the edges asked for.
void Divide(double from, double to, std::span<const double> focuses,
            const SiteResolution& resolution, std::vector<double>* points) {
  const double step = (to - from) / kSamples;
  std::array<double, kSamples + 1> cells{};  // up to each sample
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double middle = from + (static_cast<double>(i) + 0.5) * step;
    cells[i + 1] = cells[i] + step / EdgeAt(middle, focuses, resolution);
  }
  const int count = std::max(1, static_cast<int>(std::lround(cells.back())));
  std::size_t sample = 0;
  for (int i = 1; i < count; ++i) {
    const double wanted = cells.back() * i / count;
    while (cells[sample + 1] < wanted) ++sample;
    const double part = (wanted - cells[sample]) / (cells[sample + 1] - cells[sample]);
    points->push_back(from + (static_cast<double>(sample) + part) * step);
  }
  points->push_back(to);
}

}  // namespace

std::vector<double> GradedAxis(double length, std::span<const double> focuses,
                               const SiteResolution& resolution) {
  std::vector<double> wanted;
  for (const double focus : focuses) wanted.push_back(std::clamp(focus, 0.0, length));
  if (wanted.empty()) wanted.push_back(0.5 * length);
  std::ranges::sort(wanted);
  const double same = kSame * resolution.edge;
  std::vector<double> points{0};
  const auto reach = [&](double to) {
    if (to - points.back() > same) Divide(points.back(), to, wanted, resolution, &points);
  };
  for (const double focus : wanted) {
    if (length - focus > same) reach(focus);
  }
  reach(length);
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

SolidMesh MeshForFingers(const Geometry& geometry, std::span<const Vector3d> focuses_O,
                         const SiteResolution& resolution) {
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
    std::array<std::vector<double>, 3> axes;
    for (int a = 0; a < 3; ++a) {
      std::vector<double> focuses;
      for (const auto& p : focuses_O) focuses.push_back(p[a]);
      axes[static_cast<std::size_t>(a)] = GradedAxis(box->size[a], focuses, resolution);
    }
    return MeshGradedBox(axes);
  }
  SolidMesh mesh = OwnMesh(geometry);
  for (int i = 0; i < 2 && 8 * mesh.tets.size() <= resolution.most_tets; ++i) mesh = Refined(mesh);
  return mesh;
}

}  // namespace palpate::site
