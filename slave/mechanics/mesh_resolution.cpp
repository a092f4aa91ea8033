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
// Larger side by thickness above which a body bends [-]. [derived: 1.5 of a cube]
constexpr double kSlender = 2;
// Part of the true missing energy that the estimate shows, at least, where 5 % is missing [-].
// [tuned: StrainResolution.ABeamWithTooFewElementsIsExtrapolated]
constexpr double kSeen4 = 0.9, kSeen10 = 0.35;

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
    for (const auto& [i, j] : kTetEdges) {
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

StrainResolution::StrainResolution(const SolidMesh& mesh, double poisson_ratio, int nodes)
    : quadratic_(nodes == 10),
      points_(mesh.nodes),
      strains_(mesh.tets.size()),
      mean_(mesh.nodes.size()),
      volume_(mesh.nodes.size(), 0) {
  const double nu = std::min(poisson_ratio, kMostPoisson);
  mu_ = 0.5 / (1 + nu);
  lambda_ = nu / ((1 + nu) * (1 - 2 * nu));
  elements_.reserve(mesh.tets.size());
  std::unordered_map<std::uint64_t, int> middles;  // by both ends
  for (const auto& tet : mesh.tets) {
    Element element;
    std::ranges::copy(tet, element.nodes.begin());
    for (std::size_t e = 0; quadratic_ && e < kTetEdges.size(); ++e) {
      const auto [i, j] = kTetEdges[e];
      const auto ends = std::minmax(tet[Index(i)], tet[Index(j)]);
      const auto key =
          static_cast<std::uint64_t>(ends.first) << 32 | static_cast<std::uint32_t>(ends.second);
      const auto [middle, is_new] = middles.try_emplace(key, static_cast<int>(points_.size()));
      element.nodes[4 + e] = middle->second;
      if (is_new) {
        points_.emplace_back((points_[Index(ends.first)] + points_[Index(ends.second)]) / 2);
      }
    }
    Matrix3d sides;
    for (int a = 0; a < 3; ++a) {
      sides.row(a) = mesh.nodes[Index(tet[Index(a + 1)])] - mesh.nodes[Index(tet[0])];
    }
    element.volume = sides.determinant() / 6;
    element.gradients.rightCols<3>() = sides.inverse();
    element.gradients.col(0) = -element.gradients.rightCols<3>().rowwise().sum();
    for (const int node : tet) volume_[Index(node)] += element.volume;
    elements_.push_back(element);
  }
  near_.resize(points_.size());
  touched_.reserve(points_.size());
  const SurfaceMesh surface = SurfaceOf(mesh);
  double volume = 0, area = 0;
  for (const Element& element : elements_) volume += element.volume;
  for (int i = 0; i < static_cast<int>(surface.triangles.size()); ++i) area += Area(surface, i);
  thickness_ = 4 * volume / area;
  slender_ = LargerSide(mesh.nodes) > kSlender * thickness_;
}

double StrainResolution::Softness(std::span<const Vector3d> u, std::span<const int> touched) {
  if (!slender_) return 0;
  std::ranges::fill(mean_, Matrix3d::Zero());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    strains_[e] = StrainsOf(element, u);
    for (std::size_t a = 0; a < 4; ++a) {
      const auto vertex = Index(element.nodes[a]);
      mean_[vertex] += element.volume / volume_[vertex] * strains_[e][a];
    }
  }
  MarkContacts(touched);
  double energy = 0, far = 0, all = 0;
  bool some_are_far = false;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    const auto corners = std::span(element.nodes).first<4>();
    Strains step;
    for (std::size_t a = 0; a < 4; ++a) step[a] = mean_[Index(corners[a])] - strains_[e][a];
    const double missing = element.volume * TwiceEnergy(step);
    energy += element.volume * TwiceEnergy(strains_[e]);
    all += missing;
    if (std::ranges::any_of(corners, [&](int n) { return near_[Index(n)] != 0; })) continue;
    far += missing;
    some_are_far = true;
  }
  const double missing = some_are_far ? far : all;
  return energy > 0 ? missing / energy / (quadratic_ ? kSeen10 : kSeen4) : 0;
}

void StrainResolution::MarkContacts(std::span<const int> touched) {
  if (std::ranges::equal(touched, touched_)) return;
  touched_.assign(touched.begin(), touched.end());
  std::ranges::fill(near_, 0);
  for (const int node : touched) {
    const Vector3d p = points_[Index(node)];
    for (std::size_t i = 0; i < near_.size(); ++i) {
      if ((points_[i] - p).squaredNorm() <= thickness_ * thickness_) near_[i] = 1;
    }
  }
}

// At the corners, Green and Lagrange's. Gradients of the shapes there: of l_a (2 l_a - 1) 3 g_a at
// its own corner and -g_a at others, of 4 l_i l_j 4 g_j at i and 4 g_i at j.
StrainResolution::Strains StrainResolution::StrainsOf(const Element& element,
                                                      std::span<const Vector3d> u) const noexcept {
  const auto& g = element.gradients;
  const auto moved = [&](int a) -> const Vector3d& { return u[Index(element.nodes[Index(a)])]; };
  Matrix3d common = Matrix3d::Zero();
  for (int a = 0; a < 4; ++a) {
    common.noalias() += (quadratic_ ? -1 : 1) * moved(a) * g.col(a).transpose();
  }
  Strains strains;
  strains.fill(common);
  for (int a = 0; quadratic_ && a < 4; ++a) {
    strains[Index(a)].noalias() += 4 * moved(a) * g.col(a).transpose();
  }
  for (int e = 0; quadratic_ && e < 6; ++e) {
    const auto [i, j] = kTetEdges[Index(e)];
    strains[Index(i)].noalias() += 4 * moved(4 + e) * g.col(j).transpose();
    strains[Index(j)].noalias() += 4 * moved(4 + e) * g.col(i).transpose();
  }
  for (Matrix3d& H : strains) H = (0.5 * (H + H.transpose() + H.transpose() * H)).eval();
  return strains;
}

// By volume, linear between the corners: int l_a l_b = V (1 + d_ab) / 20.
double StrainResolution::TwiceEnergy(const Strains& strains) const noexcept {
  const auto of = [this](const Matrix3d& strain) {
    return 2 * mu_ * strain.squaredNorm() + lambda_ * strain.trace() * strain.trace();
  };
  double sum = of(strains[0] + strains[1] + strains[2] + strains[3]);
  for (const Matrix3d& strain : strains) sum += of(strain);
  return sum / 20;
}

}  // namespace palpate
