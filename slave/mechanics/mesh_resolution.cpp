#include "slave/mechanics/mesh_resolution.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMostOff = 0.1;
constexpr int kFewest = 3;  // pieces that may stand for a disc with a rim

constexpr double kNoRim = 1e-6;

// Pieces, by PatchBasis, from which PatchStiffness holds within a tenth; and what fewer may be off
// [-]. [measured: moved discs of 1 to 4 edges at 5 places on cubes of 4 to 10 cells, against 16
// cells of ten nodes]
constexpr std::array kReliable{6, 10, 3, 3};
constexpr double kFewOff = 0.2;

// c of PatchStiffness, by PatchBasis: what moves or loads less than it touches is softer, what
// spreads its load over the elements around is stiffer.
constexpr std::array kRimEffect{-0.05, -0.25, 0.9, 0.3};

constexpr double kMostPoisson = 0.49;
// Larger side by thickness above which a body bends [-]. [derived: 1.5 of a cube]
constexpr double kSlender = 2;
// For bodies that are no straight bars: part of the true missing energy that the recovered strains
// show, at least, where 5 % is missing [-]. [tuned:
// StrainResolution.ABeamWithTooFewElementsIsExtrapolated]
constexpr double kSeen4 = 0.9, kSeen10 = 0.35;

// How far from a support a bar is no beam yet, by its thickness [-]. [derived: the end effect of a
// strip falls as exp(-4.2 x / t) (Fadle 1941; Papkovich 1940); beyond a quarter of t 12 % of its
// energy is left, which is 0.2 % of a bar's of 5:1]
constexpr double kEnd = 0.25;

// Mean over an element of a function of strains that are linear between the corners: exact for
// quadratic forms.
template <typename Form>
double Mean(const std::array<Matrix3d, 4>& strains, const Form& of) {
  double sum = 16 * of((strains[0] + strains[1] + strains[2] + strains[3]) / 4);
  for (const Matrix3d& strain : strains) sum += of(strain);
  return sum / 20;
}

bool HasFewPieces(const PatchCover& cover) {
  return cover.disc.rim > kNoRim && cover.count < kReliable[static_cast<std::size_t>(cover.basis)];
}

}  // namespace

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

double PatchError(const PatchCover& cover) noexcept {
  if (!HasFewPieces(cover) && !IsPatchCoarse(cover)) return 0;
  const double stiffness = PatchStiffness(cover);
  if (stiffness == 0) return 1;
  return std::max(std::abs(1 / stiffness - 1), HasFewPieces(cover) ? kFewOff : 0);
}

bool IsContactCoarse(double patch_error, double disc_stiffness, const Vector3d& force,
                     const Vector3d& displacement) noexcept {
  if (patch_error == 0) return false;
  const double compliance = std::abs(force.dot(displacement)) / force.squaredNorm();
  const double share = compliance > 0 ? 1 / (disc_stiffness * compliance) : 1;
  return patch_error * std::min(1.0, share) > kMostOff;
}

StrainResolution::StrainResolution(const TetMesh& mesh, const HeldNodes& held, double poisson_ratio)
    : lame_(LameOf(std::min(poisson_ratio, kMostPoisson))),
      quadratic_(mesh.nodes_per_element == 10),
      corners_(Index(mesh.vertex_count)),
      points_(mesh.nodes),
      elements_(Index(mesh.element_count())),
      strains_(elements_.size()) {
  double volume = 0, area = 0;
  for (int e = 0; e < mesh.element_count(); ++e) {
    Element& element = elements_[Index(e)];
    std::ranges::copy(mesh.element(e), element.nodes.begin());
    element.geometry = GeometryOf(mesh.nodes, mesh.element(e));
    element.modulus = mesh.ModulusOf(e);
    volume += element.geometry.volume;
  }
  NumberMeans();
  near_.resize(points_.size());
  touched_.reserve(points_.size());
  const SurfaceMesh& surface = mesh.surface;
  for (int i = 0; i < static_cast<int>(surface.triangles.size()); ++i) area += Area(surface, i);
  thickness_ = 4 * volume / area;
  slender_ = LargerSide(surface.nodes) > kSlender * thickness_;
  FindBar(mesh.modulus.empty() ? held : HeldNodes{});
}

void StrainResolution::NumberMeans() {
  std::map<std::pair<int, double>, int> numbers;  // by node and modulus
  for (Element& element : elements_) {
    for (std::size_t a = 0; a < 4; ++a) {
      const auto [found, is_new] = numbers.try_emplace({element.nodes[a], element.modulus},
                                                       static_cast<int>(volume_.size()));
      element.means[a] = found->second;
      if (is_new) volume_.push_back(0);
      volume_[Index(found->second)] += element.geometry.volume;
    }
  }
  mean_.resize(volume_.size());
}

// Straight: across its principal direction nowhere wider than what does not bend.
void StrainResolution::FindBar(const HeldNodes& held) {
  const std::size_t count = corners_;
  Vector3d middle(0, 0, 0);
  for (std::size_t i = 0; i < count; ++i) middle += points_[i] / static_cast<double>(count);
  Matrix3d spread = Matrix3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    spread += (points_[i] - middle) * (points_[i] - middle).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(spread);  // rising
  std::array<double, 3> extents{};
  std::vector<double> places(count), supports;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < count; ++i) {
      places[i] = principal.eigenvectors().col(axis).dot(points_[i]);
    }
    const auto [least, most] = std::ranges::minmax(places);
    extents[Index(axis)] = most - least;
  }
  if (held.empty() || !slender_ || std::max(extents[0], extents[1]) > kSlender * thickness_) return;
  along_ = principal.eigenvectors().col(2);  // that of the last places
  length_ = extents[2];
  for (std::size_t i = 0; i < count; ++i) {
    if (std::ranges::any_of(held[i], std::identity())) supports.push_back(places[i]);
  }
  std::ranges::sort(supports);
  const auto from_support = [&](int node) {
    const double place = places[Index(node)];
    const auto after = std::ranges::lower_bound(supports, place);
    double distance = length_;
    if (after != supports.end()) distance = std::min(distance, *after - place);
    if (after != supports.begin()) distance = std::min(distance, place - *std::prev(after));
    return distance;
  };
  for (Element& element : elements_) {
    std::array<double, 4> at{}, apart{};
    for (std::size_t a = 0; a < 4; ++a) {
      at[a] = places[Index(element.nodes[a])];
      apart[a] = from_support(element.nodes[a]);
    }
    const auto [first, last] = std::ranges::minmax(at);
    const auto [least, most] = std::ranges::minmax(apart);
    element.extent = last - first;
    const double end = kEnd * thickness_;
    const double beyond = std::max(0.0, most - std::max(least, end));
    element.beam = most > least ? beyond / (most - least) : most > end ? 1 : 0;
  }
}

double StrainResolution::Softness(std::span<const Vector3d> u, std::span<const int> touched) {
  if (!slender_) return 0;
  const auto strain_at = [this](std::size_t element, std::size_t corner) -> const Matrix3d& {
    return strains_[element][quadratic_ ? corner : 0];
  };
  std::ranges::fill(mean_, Matrix3d::Zero());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    if (quadratic_) {
      strains_[e] = StrainsOf(element, u);
    } else {
      strains_[e][0] = StrainsOf(element, u)[0];  // that of all corners
    }
    for (std::size_t a = 0; a < 4; ++a) {
      const auto vertex = Index(element.means[a]);
      mean_[vertex] += element.geometry.volume / volume_[vertex] * strain_at(e, a);
    }
  }
  MarkContacts(touched);
  const auto energy_of = [this](const Matrix3d& strain) { return TwiceEnergy(strain); };
  const auto restraint_of = [this](const Matrix3d& strain) { return TwiceRestraint(strain); };
  const auto mean_of = [this](const Strains& strains, const auto& energy) {
    return quadratic_ ? Mean(strains, energy) : energy(strains[0]);  // else all are equal
  };
  struct Missing {
    double recovered = 0, restraint = 0;
  } far, all;
  Matrix3d mean = Matrix3d::Zero();
  double energy = 0, volume = 0, longest = 0;
  bool some_are_far = false;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    const auto corners = std::span(element.nodes).first<4>();
    Strains step;
    for (std::size_t a = 0; a < 4; ++a) {
      step[a] = mean_[Index(element.means[a])] - strain_at(e, a);
      mean += element.geometry.volume / 4 * strain_at(e, a);
    }
    const double weight = element.modulus * element.geometry.volume;
    energy += weight * mean_of(strains_[e], energy_of);
    volume += element.geometry.volume;
    longest = std::max(longest, element.extent);
    const Missing missing{weight * Mean(step, energy_of),
                          element.beam * weight * mean_of(strains_[e], restraint_of)};
    all.recovered += missing.recovered;
    all.restraint += missing.restraint;
    if (std::ranges::any_of(corners, [&](int n) { return near_[Index(n)] != 0; })) continue;
    far.recovered += missing.recovered;
    far.restraint += missing.restraint;
    some_are_far = true;
  }
  if (!(energy > 0)) return 0;
  const Missing& missing = some_are_far ? far : all;
  if (length_ == 0) return missing.recovered / energy / (quadratic_ ? kSeen10 : kSeen4);
  const double even = TwiceEnergy(mean / volume) * volume / energy;
  const double part = longest / (2 * length_);
  return std::max((missing.recovered + missing.restraint) / energy,
                  touched.empty() ? 0 : std::max(0.0, 1 - even) * part * part);
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
  const auto& g = element.geometry.grad;
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
  const auto strain_of = [](const Matrix3d& H) -> Matrix3d {
    const Matrix3d green = 0.5 * (H + H.transpose() + H.transpose() * H);
    return green - 0.5 * green * green;
  };
  if (quadratic_) {
    std::ranges::transform(strains, strains.begin(), strain_of);
  } else {
    strains.fill(strain_of(common));
  }
  return strains;
}

double StrainResolution::TwiceEnergy(const Matrix3d& strain) const noexcept {
  return 2 * lame_.mu * strain.squaredNorm() + lame_.lambda * strain.trace() * strain.trace();
}

// By E. Uniaxial stress along the bar and shear along it have none. All lateral strain restrained:
// the energy by that of uniaxial stress is (lambda + 2 mu) / E, and no more is believed.
double StrainResolution::TwiceRestraint(const Matrix3d& strain) const noexcept {
  if (length_ == 0) return 0;
  const Vector3d pulled = strain * along_;
  const double stretch = along_.dot(pulled), uniaxial = stretch * stretch;
  const Vector3d sheared = pulled - stretch * along_;
  const double energy =
      TwiceEnergy(strain - sheared * along_.transpose() - along_ * sheared.transpose());
  const double most = lame_.lambda + 2 * lame_.mu;
  return energy < most * uniaxial ? energy * (energy / uniaxial - 1) : energy * (most - 1);
}

}  // namespace palpate
