#include "slave/simulator/fingertips/site_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "slave/mechanics/object_mesh.h"

namespace palpate::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kSame = 1e-3;  // focus points closer than this are one [edges]
constexpr int kSamples = 400;   // of an integral along one axis
// Number of linear tetrahedra with as many nodes as a cubic one.
constexpr std::size_t kCubicShare = 16;

double EdgeAt(double t, std::span<const double> focuses, const SiteResolution& resolution) {
  double nearest = std::abs(t - focuses.front());
  for (const double focus : focuses) nearest = std::min(nearest, std::abs(t - focus));
  return kHexahedronDegree *
         (resolution.edge + resolution.growth * std::max(nearest - resolution.fine_reach, 0.0));
}

// An interval between two fixed positions, and the cumulative number of cells that the edge length
// requires at its samples.
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

// Gives each interval one cell, and the others one by one where cells are largest relative to the
// required size.
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

// Returns the position at `step`, counted in nodes, between the hexahedra's boundaries.
double PlaceAt(const std::vector<double>& ends, double step) {
  const auto node = static_cast<std::size_t>(std::lround(step));
  const std::size_t end = node / kHexahedronDegree, beyond = node % kHexahedronDegree;
  if (beyond == 0) return ends[end];
  return ends[end] + static_cast<double>(beyond) / kHexahedronDegree * (ends[end + 1] - ends[end]);
}

// Lattice nodes of tetrahedra, shared between neighbours. A node is identified by its numbers of
// lattice steps towards each corner.
class LatticeNodes {
 public:
  LatticeNodes(const std::vector<Vector3d>& corners, int degree)
      : corners_(corners), degree_(degree) {}

  // Returns the node at these numbers of steps from corners.front() towards each of the other
  // corners.
  int At(std::span<const int> corners, std::initializer_list<int> steps) {
    std::vector<std::pair<int, int>> shares{
        {corners[0], degree_ - std::accumulate(steps.begin(), steps.end(), 0)}};
    for (const int count : steps) shares.emplace_back(corners[shares.size()], count);
    std::erase_if(shares, [](const auto& share) { return share.second == 0; });
    std::ranges::sort(shares);
    const auto [known, is_new] = number_.try_emplace(shares, static_cast<int>(places_.size()));
    if (is_new) {
      Vector3d sum = Vector3d::Zero();
      for (const auto& [corner, count] : shares) {
        sum += count * corners_[static_cast<std::size_t>(corner)];
      }
      places_.emplace_back(sum / degree_);
    }
    return known->second;
  }
  std::vector<Vector3d> TakePlaces() { return std::move(places_); }

 private:
  const std::vector<Vector3d>& corners_;
  int degree_;
  std::vector<Vector3d> places_;
  std::map<std::vector<std::pair<int, int>>, int> number_;
};

SiteMesh Subdivided(const SolidMesh& mesh, int degree) {
  SiteMesh result{
      {}, std::make_shared<const ElementShape>(ElementShape::Tetrahedron(degree)), {}, {}};
  LatticeNodes nodes(mesh.nodes, degree);
  for (const auto& tet : mesh.tets) {
    auto& element = result.elements.emplace_back();
    for (const auto& step : result.shape->lattice.colwise()) {
      element.push_back(nodes.At(tet, {step[0], step[1], step[2]}));
    }
  }
  for (const auto& corners : SurfaceOf(mesh).triangles) {
    const auto at = [&](int i, int j) { return nodes.At(corners, {i, j}); };
    for (int i = 0; i < degree; ++i) {
      for (int j = 0; i + j < degree; ++j) {
        result.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 == degree) continue;
        result.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }
  result.nodes = nodes.TakePlaces();
  return result;
}

}  // namespace

std::vector<double> GradedAxis(const AxisGrading& axis, const SiteResolution& resolution,
                               int hexahedra) {
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
  const auto shares =
      ShareOut(stretches, hexahedra > 0 ? hexahedra : static_cast<int>(std::ceil(asked)));
  std::vector<double> points{0};
  for (std::size_t i = 0; i < stretches.size(); ++i) stretches[i].Divide(shares[i], &points);
  return points;
}

SiteMesh MeshGradedBox(const std::array<std::vector<double>, 3>& axes) {
  constexpr int kDegree = kHexahedronDegree;
  std::array<int, 3> cells{};
  for (std::size_t a = 0; a < 3; ++a) cells[a] = kDegree * (static_cast<int>(axes[a].size()) - 1);
  SolidMesh grid = MeshBox(Vector3d(cells[0], cells[1], cells[2]), cells);
  SiteMesh mesh{{}, std::make_shared<const ElementShape>(ElementShape::Cube(3, kDegree)), {}, {}};
  mesh.triangles = SurfaceOf(grid).triangles;
  for (const Vector3d& p : grid.nodes) {
    mesh.nodes.emplace_back(PlaceAt(axes[0], p[0]), PlaceAt(axes[1], p[1]), PlaceAt(axes[2], p[2]));
  }
  const auto node = [&](const Eigen::Vector3i& at) {
    return at[0] + (cells[0] + 1) * (at[1] + (cells[1] + 1) * at[2]);
  };
  for (int k = 0; k < cells[2]; k += kDegree) {
    for (int j = 0; j < cells[1]; j += kDegree) {
      for (int i = 0; i < cells[0]; i += kDegree) {
        auto& element = mesh.elements.emplace_back();
        for (const auto& step : mesh.shape->lattice.colwise()) {
          element.push_back(node(Eigen::Vector3i(i, j, k) + step));
        }
      }
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
      "object.geometry: the simulator of fingertips expects a volume: box or mesh");
}

SiteMesh MeshTetrahedra(const SolidMesh& mesh, std::size_t max_tets) {
  if (kCubicShare * mesh.tets.size() <= max_tets) return Subdivided(mesh, 3);
  SolidMesh refined = mesh;
  for (int i = 0; i < 2 && 8 * refined.tets.size() <= max_tets; ++i) refined = Refined(refined);
  return Subdivided(refined, 1);
}

}  // namespace palpate::simulation
