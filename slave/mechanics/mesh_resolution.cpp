#include "slave/mechanics/mesh_resolution.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "slave/mechanics/linear/lanes.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMaxOff = 0.1;
constexpr int kMinPieces = 3;  // smallest number of pieces that represent a disc with a rim

constexpr double kNoRim = 1e-6;

// Number of pieces, by PatchBasis, from which PatchStiffness is accurate within a tenth; and the
// error with fewer pieces [-]. [measured: moved discs of 1 to 4 edges at 5 places on cubes of 4 to
// 10 cells, compared with 16 cells of ten-node elements; ten-node elements on a block of 60 x 60 x
// 30 mm, compared with a mesh graded to the disc: with up to 25 nodes up to 20 % too stiff, with
// more 7 %]
constexpr std::array kReliable{6, 26, 3, 3};
constexpr double kFewOff = 0.2;

// c of PatchStiffness, by PatchBasis: a basis that moves or loads less than its area is softer, one
// that spreads its load over the elements around is stiffer.
constexpr std::array kRimEffect{-0.05, -0.25, 0.9, 0.3};

constexpr double kMaxPoisson = 0.4999;

// Of EffectOf, by Elements [-].
struct EffectFactors {
  double shear, volume, springs;                 // of the excess
  double shear_error, volume_error, node_error;  // of the error
};
constexpr std::array<EffectFactors, 3> kEffects{
    {{1.05, 1.35, -1.3, 0.25, 0.5, 0.1}, {0.9, 0, -0.55, 0.5, 0, 0.1}, {0, 0, 0, 0.5, 0, 0.25}}};
constexpr double kSpringError = 0.25;
constexpr double kNoSprings = 1e-3;  // share of the work below which a rim has none
// Reach of a contact's elements, in its widths and mean edges. [derived: a disc's stress falls with
// the square of the distance in widths]
constexpr double kReach = 1.5, kEdges = 2;
// Largest correction [-]. The error is then far beyond any tolerance.
constexpr double kMostExcess = 0.5;
// Ratio of larger side and thickness above which a body bends [-]. [derived: 1.5 of a cube]
constexpr double kSlender = 2;
// For bodies other than straight bars: smallest fraction of the true missing energy that the
// recovered strains show, if 5 % is missing [-]. [tuned:
// StrainResolution.ABeamWithTooFewElementsIsExtrapolated]
constexpr double kSeen4 = 0.9, kSeen10 = 0.35;

// Distance from a support up to which a bar does not behave as a beam, relative to its thickness
// [-]. [derived: the end effect of a strip falls as exp(-4.2 x / t) (Fadle 1941; Papkovich 1940);
// beyond a quarter of t 12 % of its energy is left, which is 0.2 % of a bar's of 5:1]
constexpr double kEnd = 0.25;

using fem::Double8;
using Loose8 [[gnu::vector_size(64), gnu::may_alias, gnu::aligned(8)]] = double;

// Weights of strains, and the axes in which they are expressed.
struct Weights {
  double shear, bulk;  // roots of 2 mu and K
  const double* axes;  // as rows; null: none
};

PALPATE_INLINE fem::Lanes3x3 Product(const fem::Lanes3x3& a, const fem::Lanes3x3& b) {
  fem::Lanes3x3 c;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    }
  }
  return c;
}

// Computes the strains of eight displacement gradients H: E - E^2 / 2 with E = (H + H^T + H^T H) /
// 2.
PALPATE_INLINE void Weigh(const Weights& weights, const fem::Lanes3x3& H, double* strains) {
  fem::Lanes3x3 Ht, E;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) Ht[j][i] = H[i][j];
  }
  const fem::Lanes3x3 square = Product(Ht, H);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) E[i][j] = 0.5 * (H[i][j] + Ht[i][j] + square[i][j]);
  }
  fem::Lanes3x3 strain = Product(E, E);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) strain[i][j] = E[i][j] - 0.5 * strain[i][j];
  }
  if (weights.axes != nullptr) {
    fem::Lanes3x3 R, Rt;
    for (std::size_t k = 0; k < 9; ++k) {
      R[k % 3][k / 3] = Rt[k / 3][k % 3] = Double8{} + weights.axes[k];
    }
    strain = Product(Product(R, strain), Rt);
  }
  const Double8 trace = strain[0][0] + strain[1][1] + strain[2][2];
  const double root = std::numbers::sqrt2 * weights.shear;
  const std::array<Double8, 8> weighted{weights.shear * (strain[0][0] - trace / 3),
                                        weights.shear * (strain[1][1] - trace / 3),
                                        weights.shear * (strain[2][2] - trace / 3),
                                        root * strain[0][1],
                                        root * strain[0][2],
                                        root * strain[1][2],
                                        weights.bulk * trace,
                                        Double8{}};
  for (std::size_t l = 0; l < 8; ++l) {
    for (std::size_t c = 0; c < 8; ++c) strains[8 * l + c] = weighted[c][l];
  }
}

// Of gradients that are stored column by column.
PALPATE_DISPATCHED void WeighStrains(const Weights& weights, const double* gradients,
                                     double* strains) {
  fem::Lanes3x3 H;
  for (std::size_t k = 0; k < 9; ++k) {
    for (std::size_t l = 0; l < 8; ++l) H[k % 3][k / 3][l] = gradients[9 * l + k];
  }
  Weigh(weights, H, strains);
}

// Of elements with four nodes. `shapes`: the gradients of a corner's shape function, three per
// corner; `nodes`: eight per corner; `u`: three components per node.
PALPATE_DISPATCHED void WeighLinearStrains(const Weights& weights, const Double8* shapes,
                                           const int* nodes, const double* u, double* strains) {
  fem::Lanes3x3 H{};
  for (std::size_t a = 0; a < 4; ++a) {
    std::array<Double8, 3> moved;
    for (std::size_t l = 0; l < 8; ++l) {
      const double* const at = u + 3 * static_cast<std::ptrdiff_t>(nodes[8 * a + l]);
      for (std::size_t i = 0; i < 3; ++i) moved[i][l] = at[i];
    }
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) H[i][j] += moved[i] * shapes[3 * a + j];
    }
  }
  Weigh(weights, H, strains);
}

// Strains of eight components each, at the corners of elements or constant in an element.
struct Strains {
  const double* values;
  int per_element;
  const int* elements;              // of a group
  const std::array<int, 4>* means;  // of their corners
};

// Returns the strain at a corner of an element of the group.
PALPATE_INLINE const Loose8* At(const Strains& strains, int number, int corner) {
  return reinterpret_cast<const Loose8*>(
      strains.values +
      8 * static_cast<std::ptrdiff_t>(strains.elements[number] * strains.per_element +
                                      corner % strains.per_element));
}

PALPATE_DISPATCHED void AddMeans(const Strains& strains, const double* volumes, int count,
                                 Loose8* means) {
  for (int e = 0; e < count; ++e) {
    for (int a = 0; a < 4; ++a) {
      means[strains.means[e][static_cast<std::size_t>(a)]] += volumes[e] * *At(strains, e, a);
    }
  }
}

// Returns the mean squares over an element of a field that is linear between the corners, from its
// sum and its sum of squares there: of the deviator, and of the volume.
PALPATE_INLINE std::array<double, 2> Mean(const Double8& sum, const Double8& squares) {
  const Double8 x = (sum * sum + squares) / 20;
  return {((x[0] + x[1]) + (x[2] + x[3])) + (x[4] + x[5]), x[6]};
}

// Computes for each element twice the energy of its strain, and of the difference to the mean
// strains by deviator and volume.
PALPATE_DISPATCHED void FindEnergies(const Strains& strains, const Loose8* means, int count,
                                     std::array<double, 3>* energies) {
  for (int e = 0; e < count; ++e) {
    Double8 sum{}, squares{}, steps{}, step_squares{};
    for (int a = 0; a < 4; ++a) {
      const Double8 strain = *At(strains, e, a);
      const Double8 step = means[strains.means[e][static_cast<std::size_t>(a)]] - strain;
      sum += strain;
      squares += strain * strain;
      steps += step;
      step_squares += step * step;
    }
    const auto whole = Mean(sum, squares), missing = Mean(steps, step_squares);
    energies[e] = {whole[0] + whole[1], missing[0], missing[1]};
  }
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
  const bool is_disc = cover.count >= kMinPieces || (cover.count > 0 && rim < kNoRim);
  if (!is_disc || !(cover.disc.area > 0)) return 0;
  return std::sqrt(cover.area / cover.disc.area) *
         (1 + rim * kRimEffect[static_cast<std::size_t>(cover.basis)] / std::sqrt(cover.count));
}

bool IsPatchCoarse(const PatchCover& cover) noexcept {
  return std::abs(PatchStiffness(cover) - 1) > kMaxOff;
}

double PatchError(const PatchCover& cover) noexcept {
  if (!HasFewPieces(cover) && !IsPatchCoarse(cover)) return 0;
  const double stiffness = PatchStiffness(cover);
  if (stiffness == 0) return 1;
  return std::max(std::abs(1 / stiffness - 1), HasFewPieces(cover) ? kFewOff : 0);
}

bool IsContactCoarse(double patch_error, double disc_stiffness, const Vector3d& force,
                     const Vector3d& displacement) noexcept {
  if (patch_error == 0 || (force.isZero(0) && displacement.isZero(0))) return false;
  const double compliance = std::abs(force.dot(displacement)) / force.squaredNorm();
  const double share = compliance > 0 ? 1 / (disc_stiffness * compliance) : 1;
  return patch_error * std::min(1.0, share) > kMaxOff;
}

MeshEffect EffectOf(const MeshShare& share, const ToolTouch& touch, Elements elements) noexcept {
  const EffectFactors& f = kEffects[static_cast<std::size_t>(elements)];
  const bool has_springs = touch.spring_share > kNoSprings;
  const double by_nodes = has_springs ? kSpringError * touch.spring_share
                                      : f.node_error / std::sqrt(std::max(1, touch.touching));
  return {f.shear * share.shear + f.volume * share.volume + f.springs * touch.spring_share,
          f.shear_error * share.shear + f.volume_error * share.volume + by_nodes};
}

void Correct(const MeshEffect& effect, ContactResponse* response) noexcept {
  const double rest = 1 - std::clamp(effect.excess, -kMostExcess, kMostExcess);
  response->mesh_factor = rest;
  response->force_O *= rest;
  response->stiffness_O *= rest;
  if (response->moment_O) *response->moment_O *= rest;
  response->moment_sigma *= rest;
  response->mesh_error = effect.error * response->force_O.norm();
  response->force_error = rest * response->force_error + response->mesh_error;
}

MeshEffect EffectOnLoad(const MeshShare& share) noexcept {
  return {0, share.shear + share.volume};
}

StrainResolution::StrainResolution(const TetMesh& mesh, const HeldNodes& held, double poisson_ratio)
    : lame_(LameOf(std::min(poisson_ratio, kMaxPoisson))),
      bulk_root_(std::sqrt(lame_.lambda + 2.0 / 3 * lame_.mu)),
      shear_root_(std::sqrt(2 * lame_.mu)),
      quadratic_(mesh.nodes_per_element == 10),
      corners_(Index(mesh.vertex_count)),
      points_(mesh.nodes),
      elements_(Index(mesh.element_count())),
      corners_by_modulus_(elements_.size()),
      strains_((elements_.size() + 7) / 8 * 8 * (quadratic_ ? 4 : 1)),
      found_((elements_.size() + 7) / 8),
      energies_(elements_.size()) {
  double volume = 0, area = 0;
  for (int e = 0; e < mesh.element_count(); ++e) {
    Element& element = elements_[Index(e)];
    std::ranges::copy(mesh.element(e), element.nodes.begin());
    element.geometry = GeometryOf(mesh.nodes, mesh.element(e));
    element.modulus = mesh.ModulusOf(e);
    volume += element.geometry.volume;
    Vector3d centroid(0, 0, 0);
    for (std::size_t a = 0; a < 4; ++a) centroid += points_[Index(element.nodes[a])] / 4;
    centroids_.push_back(centroid);
  }
  edge_ = std::cbrt(6 * volume / mesh.element_count());
  if (!quadratic_) PackGradients();
  NumberCorners();
  for (int e = 0; e < mesh.element_count(); ++e) AddTo(e, &all_);
  for (const auto& corners : all_.means) {
    for (const int corner : corners) number_[Index(corner)] = -1;
  }
  near_.resize(elements_.size());
  touched_.reserve(points_.size());
  const SurfaceMesh& surface = mesh.surface;
  for (int i = 0; i < static_cast<int>(surface.triangles.size()); ++i) area += Area(surface, i);
  thickness_ = 4 * volume / area;
  slender_ = LargerSide(surface.nodes) > kSlender * thickness_;
  FindBar(mesh.modulus.empty() ? held : HeldNodes{});
}

void StrainResolution::PackGradients() {
  gradients_.resize(found_.size());
  lane_nodes_.resize(found_.size());
  for (std::size_t e = 0; e < 8 * found_.size(); ++e) {
    const Element& element = elements_[std::min(e, elements_.size() - 1)];
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t i = 0; i < 3; ++i) {
        gradients_[e / 8][3 * a + i][e % 8] = element.geometry.grad(i, a);
      }
      lane_nodes_[e / 8][8 * a + e % 8] = element.nodes[a];
    }
  }
}

void StrainResolution::NumberCorners() {
  std::map<std::pair<int, double>, int> numbers;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    for (std::size_t a = 0; a < 4; ++a) {
      const auto [found, is_new] = numbers.try_emplace({element.nodes[a], element.modulus},
                                                       static_cast<int>(numbers.size()));
      corners_by_modulus_[e][a] = found->second;
    }
  }
  number_.assign(numbers.size(), -1);
  mean_.resize(numbers.size());
}

void StrainResolution::AddTo(int element, Group* group) {
  const double volume = elements_[Index(element)].geometry.volume;
  auto& means = group->means.emplace_back();
  for (std::size_t a = 0; a < 4; ++a) {
    int& number = number_[Index(corners_by_modulus_[Index(element)][a])];
    if (number < 0) {
      number = static_cast<int>(group->around.size());
      group->around.push_back(0);
    }
    means[a] = number;
    group->around[Index(number)] += volume;
  }
  group->elements.push_back(element);
  group->volumes.push_back(volume);
  group->weights.push_back(volume * elements_[Index(element)].modulus);
}

void StrainResolution::FindRegion(const Touch& touch, Region* region) {
  region->touch = touch;
  Group& group = region->group;
  if (group.elements.capacity() == 0) {  // regions of later places allocate nothing
    group.elements.reserve(elements_.size());
    group.means.reserve(elements_.size());
    group.volumes.reserve(elements_.size());
    group.weights.reserve(elements_.size());
    group.around.reserve(number_.size());
  }
  group.elements.clear();
  group.means.clear();
  group.volumes.clear();
  group.weights.clear();
  group.around.clear();
  const double reach = kReach * touch.width + kEdges * edge_;
  for (std::size_t e = 0; e < centroids_.size(); ++e) {
    if ((centroids_[e] - touch.centre).squaredNorm() > reach * reach) continue;
    AddTo(static_cast<int>(e), &group);
  }
  for (const int e : group.elements) {
    for (const int corner : corners_by_modulus_[Index(e)]) number_[Index(corner)] = -1;
  }
}

// Finds whether the body is a straight bar: across its principal direction it is nowhere wider than
// a non-bending part.
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
  axes_ = principal.eigenvectors().rowwise().reverse().transpose();
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

void StrainResolution::Take(std::span<const Vector3d> u) {
  u_ = u;
  std::ranges::fill(found_, 0);
}

double StrainResolution::Softness(std::span<const int> touched) {
  if (!slender_) return 0;
  FindEnergiesOf(all_);
  return Bending(touched);
}

MeshShare StrainResolution::ShareNear(std::size_t number, const Touch& touch, double work) {
  if (regions_.size() <= number) regions_.resize(number + 1);
  Region& region = regions_[number];
  if (region.touch.centre != touch.centre || region.touch.width != touch.width) {
    FindRegion(touch, &region);
  }
  const Group& group = region.group;
  if (group.elements.empty()) return {};
  FindEnergiesOf(group);
  MeshShare share;
  double energy = 0;
  for (std::size_t i = 0; i < group.elements.size(); ++i) {
    const double weight = group.weights[i];
    energy += weight * energies_[i][0];
    share.shear += weight * energies_[i][1];
    share.volume += weight * energies_[i][2];
  }
  energy = std::max(energy, work);
  if (!(energy > 0)) return {};
  return {share.shear / energy, share.volume / energy};
}

// Finds the strains of eight elements. After the last element it is repeated.
void StrainResolution::FindStrains(std::size_t batch) noexcept {
  const Weights weights{shear_root_, bulk_root_, length_ > 0 ? axes_.data() : nullptr};
  if (!quadratic_) {
    WeighLinearStrains(weights, gradients_[batch].data(), lane_nodes_[batch].data(),
                       u_.front().data(), strains_[8 * batch].data());
    return;
  }
  std::array<Matrix3d, 8> gradients;
  for (std::size_t e = 8 * batch; e < 8 * batch + 8; e += 2) {
    for (std::size_t k = 0; k < 2; ++k) {
      FindGradients(elements_[std::min(e + k, elements_.size() - 1)], &gradients[4 * k]);
    }
    WeighStrains(weights, gradients.front().data(), strains_[4 * e].data());
  }
}

void StrainResolution::FindEnergiesOf(const Group& group) noexcept {
  const std::size_t count = group.elements.size();
  for (const int e : group.elements) {
    const std::size_t batch = Index(e) / 8;
    if (std::exchange(found_[batch], 1) == 0) FindStrains(batch);
  }
  const Strains strains{strains_.front().data(), quadratic_ ? 4 : 1, group.elements.data(),
                        group.means.data()};
  auto* const means = reinterpret_cast<Loose8*>(mean_.front().data());
  std::fill_n(mean_.begin(), group.around.size(), Strain::Zero());
  AddMeans(strains, group.volumes.data(), static_cast<int>(count), means);
  for (std::size_t i = 0; i < group.around.size(); ++i) mean_[i] /= group.around[i];
  FindEnergies(strains, means, static_cast<int>(count), energies_.data());
}

double StrainResolution::Bending(std::span<const int> touched) {
  const std::size_t per_element = quadratic_ ? 4 : 1;
  MarkContacts(touched);
  // The mean is computed from the corners and, with 16 of 20 parts, the centre.
  const auto restraint_of = [&](std::size_t e) {
    const Strain* at = &strains_[per_element * e];
    if (!quadratic_) return TwiceRestraint(*at);
    double sum = 16 * TwiceRestraint((at[0] + at[1] + at[2] + at[3]) / 4);
    for (int a = 0; a < 4; ++a) sum += TwiceRestraint(at[a]);
    return sum / 20;
  };
  struct Missing {
    double recovered = 0, restraint = 0;
  } far, all;
  Strain mean = Strain::Zero();
  double energy = 0, volume = 0, longest = 0;
  bool some_are_far = false;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const double weight = all_.weights[e];
    energy += weight * energies_[e][0];
    Missing missing{weight * (energies_[e][1] + energies_[e][2]), 0};
    if (length_ > 0) {
      const Element& element = elements_[e];
      for (std::size_t a = 0; a < per_element; ++a) {
        mean += all_.volumes[e] / static_cast<double>(per_element) * strains_[per_element * e + a];
      }
      volume += all_.volumes[e];
      longest = std::max(longest, element.extent);
      missing.restraint = element.beam * weight * restraint_of(e);
    }
    all.recovered += missing.recovered;
    all.restraint += missing.restraint;
    if (near_[e] != 0) continue;
    far.recovered += missing.recovered;
    far.restraint += missing.restraint;
    some_are_far = true;
  }
  if (!(energy > 0)) return 0;
  const Missing& missing = some_are_far ? far : all;
  if (length_ == 0) return missing.recovered / energy / (quadratic_ ? kSeen10 : kSeen4);
  const double even = mean.squaredNorm() / (volume * energy);
  const double part = longest / (2 * length_);
  return std::max((missing.recovered + missing.restraint) / energy,
                  touched.empty() ? 0 : std::max(0.0, 1 - even) * part * part);
}

void StrainResolution::MarkContacts(std::span<const int> touched) {
  if (std::ranges::equal(touched, touched_)) return;
  touched_.assign(touched.begin(), touched.end());
  std::vector<char> is_near(points_.size(), 0);  // per node
  for (std::size_t i = 0; i < is_near.size(); ++i) {
    is_near[i] = std::ranges::any_of(touched, [&](int node) {
      const Vector3d apart = points_[i] - points_[Index(node)];
      return std::abs(apart.x()) <= thickness_ && apart.squaredNorm() <= thickness_ * thickness_;
    });
  }
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const auto corners = std::span(elements_[e].nodes).first<4>();
    near_[e] = std::ranges::any_of(corners, [&](int n) { return is_near[Index(n)] != 0; }) ? 1 : 0;
  }
}

// Gradients of the displacement at the corners of elements with ten nodes. Gradients of the shape
// functions there: for l_a (2
// l_a - 1), 3 g_a at its own corner and -g_a at others; for 4 l_i l_j, 4 g_j at i and 4 g_i at j.
void StrainResolution::FindGradients(const Element& element, Matrix3d* gradients) const noexcept {
  const auto& g = element.geometry.grad;
  const auto moved = [&](int a) -> const Vector3d& { return u_[Index(element.nodes[Index(a)])]; };
  Matrix3d common = Matrix3d::Zero();
  for (int a = 0; a < 4; ++a) common.noalias() -= moved(a) * g.col(a).transpose();
  std::fill_n(gradients, 4, common);
  for (int a = 0; a < 4; ++a) {
    gradients[Index(a)].noalias() += 4 * moved(a) * g.col(a).transpose();
  }
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[Index(e)];
    gradients[Index(i)].noalias() += 4 * moved(4 + e) * g.col(j).transpose();
    gradients[Index(j)].noalias() += 4 * moved(4 + e) * g.col(i).transpose();
  }
}

// The result is relative to E. Uniaxial stress and shear along the bar have no restraint. With all
// lateral strain prevented, the energy relative to uniaxial stress is (lambda + 2 mu) / E, the
// largest accepted ratio.
double StrainResolution::TwiceRestraint(const Strain& strain) const noexcept {
  const double stretch = strain[0] / shear_root_ + strain[6] / (3 * bulk_root_);
  const double uniaxial = stretch * stretch;
  const double energy = strain.squaredNorm() - strain.segment<2>(3).squaredNorm();
  const double most = lame_.lambda + 2 * lame_.mu;
  return energy < most * uniaxial ? energy * (energy / uniaxial - 1) : energy * (most - 1);
}

}  // namespace palpate
