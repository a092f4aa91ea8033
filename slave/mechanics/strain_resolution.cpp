#include "slave/mechanics/strain_resolution.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include <Eigen/LU>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMostPoisson = 0.49;
constexpr std::array<std::array<int, 2>, 6> kEdges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

}  // namespace

StrainResolution::StrainResolution(const SolidMesh& mesh,
                                   const std::vector<std::array<bool, 3>>& held,
                                   double poisson_ratio)
    : near_(mesh.nodes.size(), 0) {
  const double nu = std::min(poisson_ratio, kMostPoisson);
  mu_ = 0.5 / (1 + nu);
  lambda_ = nu / ((1 + nu) * (1 - 2 * nu));
  elements_.reserve(mesh.tets.size());
  for (const auto& tet : mesh.tets) {
    Element element;
    element.nodes = tet;
    Matrix3d sides;
    for (int a = 0; a < 3; ++a) {
      sides.row(a) = mesh.nodes[Index(tet[Index(a + 1)])] - mesh.nodes[Index(tet[0])];
    }
    element.volume = sides.determinant() / 6;
    element.gradients.rightCols<3>() = sides.inverse();
    element.gradients.col(0) = -element.gradients.rightCols<3>().rowwise().sum();
    elements_.push_back(element);
  }
  Number(held);
}

// Edges, and how stiff each is on its own: the trace of its block by three, with
// G = int grad b grad b^T, b = 4 l_i l_j.
void StrainResolution::Number(const std::vector<std::array<bool, 3>>& held) {
  std::map<std::pair<int, int>, int> known;
  std::vector<double> stiffness;
  for (Element& element : elements_) {
    for (std::size_t e = 0; e < kEdges.size(); ++e) {
      const auto [i, j] = kEdges[e];
      const auto ends = std::minmax(element.nodes[Index(i)], element.nodes[Index(j)]);
      const auto [edge, is_new] = known.try_emplace(ends, static_cast<int>(ends_.size()));
      if (is_new) {
        ends_.push_back({ends.first, ends.second});
        stiffness.push_back(0);
      }
      element.edges[e] = edge->second;
      const Vector3d gi = element.gradients.col(i), gj = element.gradients.col(j);
      const double trace =
          1.6 * element.volume * (gi.squaredNorm() + gj.squaredNorm() + gi.dot(gj));
      stiffness[Index(edge->second)] += (4 * mu_ + lambda_) / 3 * trace;
    }
  }
  compliance_.reserve(ends_.size());
  for (std::size_t e = 0; e < ends_.size(); ++e) {
    const auto& a = held[Index(ends_[e][0])];
    const auto& b = held[Index(ends_[e][1])];
    Vector3d free(1, 1, 1);
    for (int c = 0; c < 3; ++c) free[c] = a[Index(c)] && b[Index(c)] ? 0 : 1;
    compliance_.emplace_back(free / stiffness[e]);
  }
  residual_.resize(ends_.size());
}

double StrainResolution::Softness(std::span<const Vector3d> u,
                                  std::span<const int> touched) noexcept {
  for (auto& r : residual_) r.setZero();
  twice_energy_ = 0;
  for (const Element& element : elements_) AddElement(element, u);
  MarkContacts(touched);
  double bowed = 0;
  for (std::size_t e = 0; e < ends_.size(); ++e) {
    if (near_[Index(ends_[e][0])] != 0 || near_[Index(ends_[e][1])] != 0) continue;
    bowed += compliance_[e].dot(residual_[e].cwiseAbs2());
  }
  return twice_energy_ > 0 ? bowed / twice_energy_ : 0;
}

void StrainResolution::MarkContacts(std::span<const int> touched) noexcept {
  constexpr char kTouched = 2;
  std::ranges::fill(near_, 0);
  for (const int node : touched) near_[Index(node)] = kTouched;
  for (const Element& element : elements_) {
    if (std::ranges::none_of(element.nodes, [&](int n) { return near_[Index(n)] == kTouched; })) {
      continue;
    }
    for (const int node : element.nodes) near_[Index(node)] = std::max<char>(near_[Index(node)], 1);
  }
}

void StrainResolution::AddElement(const Element& element, std::span<const Vector3d> u) noexcept {
  Matrix3d H = Matrix3d::Zero();  // displacement gradient
  for (int a = 0; a < 4; ++a) {
    H.noalias() += u[Index(element.nodes[Index(a)])] * element.gradients.col(a).transpose();
  }
  const Matrix3d strain = 0.5 * (H + H.transpose() + H.transpose() * H);  // Green and Lagrange
  Matrix3d stress = 2 * mu_ * strain;
  stress.diagonal().array() += lambda_ * strain.trace();
  twice_energy_ += element.volume * stress.cwiseProduct(strain).sum();
  const Eigen::Matrix<double, 3, 4> pull = element.volume * stress * element.gradients;
  for (std::size_t e = 0; e < kEdges.size(); ++e) {
    const auto [i, j] = kEdges[e];
    residual_[Index(element.edges[e])] += pull.col(i) + pull.col(j);
  }
}

}  // namespace palpate
