#include "slave/site/points/membrane/disc_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>

namespace palpate::site {
namespace {

using Eigen::Vector2d;

constexpr double kGrowth = 0.45;  // of an element's size per distance from where it bends

// Ends of `count` intervals of [0, 1] as long as `size` asks, up to a common factor.
std::vector<double> Divide(int count, const std::function<double(double)>& size) {
  constexpr int kSteps = 2000;
  std::vector<double> sum(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    sum[static_cast<std::size_t>(i) + 1] =
        sum[static_cast<std::size_t>(i)] + 1 / size((i + 0.5) / kSteps);
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

// Numbers the crossings of lines by nested dissection along the elements' borders, so that the
// factor of a matrix over them stays sparse (George 1973).
class Dissector {
 public:
  Dissector(int last_ray, const std::function<void(int, int)>& number)
      : last_ray_(last_ray), number_(number) {}

  // Crossings strictly between the lines given, and those on the sector's own borders.
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

}  // namespace

DiscMesh::DiscMesh(const NestedCircles& circles, double thickness, const Size& size)
    : circles_(circles), thickness_(thickness), size_(size) {
  PlaceCircles();
  OrderColumns();
}

void DiscMesh::PlaceCircles() {
  const double gap = circles_.radius - circles_.tool;
  const double near = circles_.tool + thickness_, rim = 0.5 * thickness_;  // lengths of bending
  const auto outer = [&](double x) {
    return std::min(near + kGrowth * 2 * gap * x, rim + kGrowth * 2 * gap * (1 - x));
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
  column_.assign(static_cast<std::size_t>(1 + (circle_lines() - 1) * ray_lines()), 0);
  const double sector = is_quarter() ? std::numbers::pi / 2 : std::numbers::pi;
  const std::function<void(int, int)> number = [&](int circle, int ray) {
    const int i = circle == 0 ? 0 : 1 + (circle - 1) * ray_lines() + ray;
    column_[static_cast<std::size_t>(i)] = columns();
    places_.push_back(
        circles_.At({s_[static_cast<std::size_t>(circle)], sector * ray / (ray_lines() - 1)}));
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

}  // namespace palpate::site
