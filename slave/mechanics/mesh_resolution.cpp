#include "slave/mechanics/mesh_resolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include <Eigen/LU>

#include "shared/geometry/index.h"
#include "shared/mesh/mesh_census.h"
#include "shared/mesh/mesh_check.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMostOff = 0.1;
constexpr int kFewest = 3;  // pieces that may stand for a disc with a rim

constexpr double kNoRim = 1e-6;

// c of PatchStiffness, by PatchBasis: what moves or loads less than it touches is softer, what
// spreads its load over the elements around is stiffer.
constexpr std::array kRimEffect{-0.05, -0.25, 0.9, 0.3, -0.15};

constexpr double kMostPoisson = 0.49;
constexpr std::array<std::array<int, 2>, 6> kEdges{
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

}  // namespace

void RequireReadable(const SolidMesh& mesh) {
  MeshReport report;
  IsReadable(mesh.nodes, mesh.tets, {}, &report);
  RequireSound(report);
}

void RequireOnePerNode(const HeldNodes& held, const SolidMesh& mesh) {
  if (held.size() == mesh.nodes.size()) return;
  throw std::invalid_argument("fixed nodes = " + std::to_string(held.size()) +
                              ": accepted is one per node, " + std::to_string(mesh.nodes.size()));
}

void RequireVolumes(const SolidMesh& mesh, double least) {
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double longest = 0;
    for (const auto& [i, j] : kEdges) {
      const int a = mesh.tets[t][Index(i)], b = mesh.tets[t][Index(j)];
      longest = std::max(longest, (mesh.nodes[Index(a)] - mesh.nodes[Index(b)]).norm());
    }
    if (SignedVolume(mesh, static_cast<int>(t)) > least * longest * longest * longest) continue;
    throw std::invalid_argument("tetrahedron " + std::to_string(t) +
                                ": accepted is a volume > 0, it is flat or inverted");
  }
}

PatchCover CoverOf(const DiscPatch& patch, PatchBasis basis) noexcept {
  if (basis == PatchBasis::kMovedNodes || basis == PatchBasis::kMovedNodes10) {
    return {basis, patch.disc, patch.node_area, static_cast<int>(patch.nodes.size())};
  }
  return {basis, patch.disc, patch.triangle_area, static_cast<int>(patch.triangles.size())};
}

double PatchStiffness(const PatchCover& cover) noexcept {
  const double rim = std::clamp(cover.disc.rim / (2 * std::numbers::pi), 0.0, 1.0);
  const bool is_disc = cover.count >= kFewest || (cover.count > 0 && rim < kNoRim);
  if (!is_disc || !(cover.disc.area > 0)) return 0;
  return std::sqrt(cover.area / cover.disc.area) *
         (1 + rim * kRimEffect[static_cast<std::size_t>(cover.basis)] / std::sqrt(cover.count));
}

bool IsPatchCoarse(const PatchCover& cover) noexcept {
  return std::abs(PatchStiffness(cover) - 1) > kMostOff;
}

StrainResolution::StrainResolution(const SolidMesh& mesh, const HeldNodes& held,
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
void StrainResolution::Number(const HeldNodes& held) {
  std::unordered_map<std::uint64_t, int> known;  // by both ends
  known.reserve(2 * elements_.size());
  std::vector<double> stiffness;
  for (Element& element : elements_) {
    for (std::size_t e = 0; e < kEdges.size(); ++e) {
      const auto [i, j] = kEdges[e];
      const auto ends = std::minmax(element.nodes[Index(i)], element.nodes[Index(j)]);
      const auto key =
          static_cast<std::uint64_t>(ends.first) << 32 | static_cast<std::uint32_t>(ends.second);
      const auto [edge, is_new] = known.try_emplace(key, static_cast<int>(ends_.size()));
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
