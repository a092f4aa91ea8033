#include "slave/reference/membrane/neo_hookean_disc.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

#include "slave/mesh/index.h"

namespace palpate::simulation {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// Growth of the element size per distance from regions of strong bending.
constexpr double kRingGrowth = 0.45;

// Divides [0, 1] into `count` intervals whose lengths are proportional to `size`.
std::vector<double> Divide(int count, const std::function<double(double)>& size) {
  constexpr int kSteps = 2000;
  std::vector<double> sum(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    sum[Index(i) + 1] = sum[Index(i)] + 1 / size((i + 0.5) / kSteps);
  }
  std::vector<double> ends{0};
  for (int k = 1; k < count; ++k) {
    const double target = sum.back() * k / count;
    const auto above = std::ranges::upper_bound(sum, target);
    const double below = *(above - 1);
    ends.push_back(
        (static_cast<double>(above - sum.begin() - 1) + (target - below) / (*above - below)) /
        kSteps);
  }
  ends.push_back(1);
  return ends;
}

// Numbers the nodes of the grid by nested dissection along the elements' borders, so that the
// factor of a matrix stays sparse (George 1973).
class Dissector {
 public:
  Dissector(int last_ray, const std::function<void(int, int)>& number)
      : last_ray_(last_ray), number_(number) {}

  // Numbers the nodes strictly between the given grid lines, and those on the sector's own borders.
  void Number(int circle_0, int circle_1, int ray_0, int ray_1) {
    constexpr int kStep = DiscMesh::kAcross;
    const int circles = (circle_1 - circle_0) / kStep, rays = (ray_1 - ray_0) / kStep;
    const int first = ray_0 == 0 ? 0 : ray_0 + 1, last = ray_1 == last_ray_ ? ray_1 : ray_1 - 1;
    if (circles <= 1 && rays <= 1) {
      for (int c = circle_0 + 1; c < circle_1; ++c) {
        for (int r = first; r <= last; ++r) number_(c, r);
      }
    } else if (circles >= rays) {
      const int middle = circle_0 + circles / 2 * kStep;
      Number(circle_0, middle, ray_0, ray_1);
      Number(middle, circle_1, ray_0, ray_1);
      for (int r = first; r <= last; ++r) number_(middle, r);
    } else {
      const int middle = ray_0 + rays / 2 * kStep;
      Number(circle_0, circle_1, ray_0, middle);
      Number(circle_0, circle_1, middle, ray_1);
      for (int c = circle_0 + 1; c < circle_1; ++c) number_(c, middle);
    }
  }

 private:
  int last_ray_;
  const std::function<void(int, int)>& number_;
};

static_assert(DiscMesh::kAcross == DiscMesh::kThrough);

PlacedElement ElementOf(const DiscMesh& mesh, int ring, int ray, int layer) {
  static const ElementShape cube = ElementShape::Cube(3, DiscMesh::kAcross);
  std::vector<int> nodes;
  MatrixXd places(3, cube.nodes());
  for (const int column : mesh.element(ring, ray)) {
    for (int i = 0; i <= DiscMesh::kThrough; ++i) {
      const int level = DiscMesh::kThrough * layer + i;
      places.col(static_cast<Eigen::Index>(nodes.size())) << mesh.place(column),
          mesh.thickness() * level / (mesh.levels() - 1);
      nodes.push_back(mesh.levels() * column + level);
    }
  }
  return {cube, places, std::move(nodes)};
}

std::vector<PlacedElement> ElementsOf(const DiscMesh& mesh) {
  std::vector<PlacedElement> elements;
  for (int ring = 0; ring < mesh.rings(); ++ring) {
    for (int ray = 0; ray < mesh.rays(); ++ray) {
      for (int layer = 0; layer < mesh.layers(); ++layer) {
        elements.push_back(ElementOf(mesh, ring, ray, layer));
      }
    }
  }
  return elements;
}

}  // namespace

using Eigen::Vector2d;

Vector2d NestedCircles::At(const Place& place) const noexcept {
  const double way = std::max(place.s - 1, 0.0);  // from the tool's edge to the rim
  const double r = std::min(place.s, 1.0) * tool + way * (radius - tool);
  return {(1 - way) * eccentricity + r * std::cos(place.angle), r * std::sin(place.angle)};
}

// Finds the circle at the share `way` from the tool to the rim, |d + way e| = tool + way (radius -
// tool) with d from the tool's centre and e the eccentricity: a quadratic equation, one of whose
// roots is positive.
NestedCircles::Place NestedCircles::Of(const Vector2d& p) const noexcept {
  const Vector2d d(p.x() - eccentricity, p.y());
  const double distance = d.norm();
  if (distance <= tool) return {distance / tool, std::atan2(d.y(), d.x())};
  const double gap = radius - tool;
  const double A = gap * gap - eccentricity * eccentricity;
  const double half_B = d.x() * eccentricity - tool * gap;
  const double C = (distance - tool) * (distance + tool);
  const double way = (half_B + std::sqrt(half_B * half_B + A * C)) / A;
  return {1 + way, std::atan2(d.y(), d.x() + way * eccentricity)};
}

DiscMesh::DiscMesh(const NestedCircles& circles, double thickness, const Size& size)
    : circles_(circles), thickness_(thickness), size_(size) {
  PlaceCircles();
  OrderColumns();
}

void DiscMesh::PlaceCircles() {
  const double gap = circles_.radius - circles_.tool;
  // Lengths over which the sheet bends.
  const double near = circles_.tool + thickness_, rim = 0.5 * thickness_;
  const auto outer = [&](double x) {
    return std::min(near + kRingGrowth * 2 * gap * x, rim + kRingGrowth * 2 * gap * (1 - x));
  };
  std::vector<double> ends;
  for (int i = 0; i < size_.inner_rings; ++i) {
    ends.push_back(static_cast<double>(i) / size_.inner_rings);
  }
  for (const double x : Divide(size_.outer_rings, outer)) ends.push_back(1 + x);
  s_ = {0};
  for (std::size_t e = 1; e < ends.size(); ++e) {
    for (int k = 1; k <= kAcross; ++k) {
      s_.push_back(ends[e - 1] + (ends[e] - ends[e - 1]) * k / kAcross);
    }
  }
}

void DiscMesh::OrderColumns() {
  column_.assign(Index(1 + (circle_lines() - 1) * ray_lines()), 0);
  const double sector = is_quarter() ? std::numbers::pi / 2 : std::numbers::pi;
  const std::function<void(int, int)> number = [&](int circle, int ray) {
    const int i = circle == 0 ? 0 : 1 + (circle - 1) * ray_lines() + ray;
    column_[Index(i)] = columns();
    places_.push_back(circles_.At({s_[Index(circle)], sector * ray / (ray_lines() - 1)}));
  };
  const int rim = circle_lines() - 1, last = ray_lines() - 1;
  Dissector(last, number).Number(0, rim, 0, last);
  number(0, 0);
  free_columns_ = columns();
  for (int ray = 0; ray <= last; ++ray) number(rim, ray);
}

std::array<int, DiscMesh::kElementColumns> DiscMesh::element(int ring, int ray) const {
  std::array<int, kElementColumns> columns{};
  std::size_t k = 0;
  for (int i = 0; i <= kAcross; ++i) {
    for (int j = 0; j <= kAcross; ++j) {
      columns[k++] = column(kAcross * ring + i, kAcross * ray + j);
    }
  }
  return columns;
}

std::array<bool, 3> DiscMesh::Held(int circle, int ray) const {
  const bool first = ray == 0 || circle == 0, last = ray == ray_lines() - 1 || circle == 0;
  return {last && is_quarter(), first || (last && !is_quarter()), false};
}

NeoHookeanDisc::NeoHookeanDisc(const DiscMesh& mesh, double nu, double tension)
    : mesh_(mesh),
      body_(ElementsOf(mesh), mesh.levels() * mesh.free_columns(), NeoHookean(nu, tension)) {
  free_.setOnes(size());
  for (int circle = 0; circle + 1 < mesh.circle_lines(); ++circle) {
    for (int ray = 0; ray < mesh.ray_lines(); ++ray) {
      const auto held = mesh.Held(circle, ray);
      for (int i = 0; i < 3 * mesh.levels(); ++i) {
        if (held[Index(i % 3)]) free_[unknown(mesh.column(circle, ray), i / 3, i % 3)] = 0;
      }
    }
  }
}

VectorXd NeoHookeanDisc::ToolLoad() const {
  static const ElementShape face = ElementShape::Cube(2, DiscMesh::kAcross);
  VectorXd load = VectorXd::Zero(size());
  MatrixXd places(2, face.nodes());
  for (int ring = 0; ring < mesh_.inner_rings(); ++ring) {
    for (int ray = 0; ray < mesh_.rays(); ++ray) {
      const auto columns = mesh_.element(ring, ray);
      for (int i = 0; i < face.nodes(); ++i) places.col(i) = mesh_.place(columns[Index(i)]);
      const VectorXd shares = face.values * PlacedElement(face, places, {}).weights;
      for (int i = 0; i < face.nodes(); ++i) {
        load[unknown(columns[Index(i)], mesh_.levels() - 1, 2)] -= shares[i];
      }
    }
  }
  return load / (-load.sum() * (mesh_.is_quarter() ? 4 : 2));
}

bool NeoHookeanDisc::Forces(const VectorXd& u, VectorXd* forces) const {
  if (!body_.Forces(u, forces)) return false;
  *forces = forces->cwiseProduct(free_);
  return true;
}

bool NeoHookeanDisc::Linearise(const VectorXd& u, VectorXd* forces, Matrix* stiffness) const {
  if (!body_.Linearise(u, forces, stiffness)) return false;
  *forces = forces->cwiseProduct(free_);
  NeoHookeanBody::Hold(free_, stiffness);
  return true;
}

}  // namespace palpate::simulation
