#include "slave/mechanics/fem/zone/neo_hookean_tets.h"

#include <algorithm>
#include <limits>

#include "slave/mechanics/fem/neo_hookean_lanes.h"
#include "slave/mechanics/tet_mesh.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using fem::Double8;
using fem::kLanes;
using fem::Lanes3x3;
using Group = NeoHookeanTets::Group;
using Law = NeoHookeanTets::Law;

PALPATE_INLINE Lanes3x3 DisplacementGradient(const Group& group, const double* u) {
  std::array<std::array<Double8, 3>, 4> corner;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double* at = u + group.node[a][l];
      for (std::size_t c = 0; c < 3; ++c) corner[a][c][l] = at[c];
    }
  }
  Lanes3x3 H;
  for (std::size_t i = 0; i < 3; ++i) {
    const Double8 d1 = corner[1][i] - corner[0][i], d2 = corner[2][i] - corner[0][i],
                  d3 = corner[3][i] - corner[0][i];
    for (std::size_t j = 0; j < 3; ++j) {
      H[i][j] = d1 * group.gradient[0][j] + d2 * group.gradient[1][j] + d3 * group.gradient[2][j];
    }
  }
  return H;
}

// J: det F.
PALPATE_INLINE Lanes3x3 Stress(const Law& law, Lanes3x3 F, Double8* J_out) {
  Double8 invariant{};
  for (std::size_t i = 0; i < 3; ++i) F[i][i] += 1;
  for (const auto& row : F) invariant += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
  const Lanes3x3 C = fem::CofactorOf(F);
  const Double8 J = F[0][0] * C[0][0] + F[0][1] * C[0][1] + F[0][2] * C[0][2];
  *J_out = J;
  const Double8 a = law.m * (1 - 1 / (invariant + 1));
  const Double8 s = law.k * (J - 1) - 0.75 * law.m;
  Lanes3x3 P;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) P[i][j] = a * F[i][j] + s * C[i][j];
  }
  return P;
}

PALPATE_INLINE Lanes3x3 LinearStress(const Law& law, const Lanes3x3& H) {
  const Double8 pressure = law.lambda * (H[0][0] + H[1][1] + H[2][2]);
  Lanes3x3 P;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) P[i][j] = law.mu * (H[i][j] + H[j][i]);
    P[i][i] += pressure;
  }
  return P;
}

PALPATE_INLINE void Scatter(const Group& group, const Lanes3x3& P, double* force) {
  std::array<std::array<Double8, 3>, 4> corner;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t a = 0; a < 3; ++a) {
      corner[a + 1][c] =
          group.volume * (P[c][0] * group.gradient[a][0] + P[c][1] * group.gradient[a][1] +
                          P[c][2] * group.gradient[a][2]);
    }
    corner[0][c] = -(corner[1][c] + corner[2][c] + corner[3][c]);
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    for (std::size_t a = 0; a < 4; ++a) {
      double* at = force + group.node[a][l];
      for (std::size_t c = 0; c < 3; ++c) at[c] += corner[a][c][l];
    }
  }
}

PALPATE_DISPATCHED void AddForces(const Law& law, const Group* groups, std::size_t count,
                                  const double* u, double* force) {
  for (std::size_t g = 0; g < count; ++g) {
    Double8 J;
    Scatter(groups[g], Stress(law, DisplacementGradient(groups[g], u), &J), force);
  }
}

PALPATE_DISPATCHED double AddNonlinearForces(const Law& law, const Group* groups, std::size_t count,
                                             const double* u, double* force) {
  Double8 smallest{}, J;
  for (std::size_t l = 0; l < kLanes; ++l) smallest[l] = std::numeric_limits<double>::infinity();
  for (std::size_t g = 0; g < count; ++g) {
    const Lanes3x3 H = DisplacementGradient(groups[g], u), linear = LinearStress(law, H);
    Lanes3x3 P = Stress(law, H, &J);
    smallest = J < smallest ? J : smallest;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) P[i][j] -= linear[i][j];
    }
    Scatter(groups[g], P, force);
  }
  double least = smallest[0];
  for (std::size_t l = 1; l < kLanes; ++l) least = smallest[l] < least ? smallest[l] : least;
  return least;
}

}  // namespace

NeoHookeanTets::NeoHookeanTets(std::span<const std::array<int, 4>> corners,
                               const std::vector<Vector3d>& nodes, double nu,
                               std::span<const double> moduli)
    : corners_(corners.begin(), corners.end()) {
  const Lame lame = LameOf(nu);
  law_.mu = lame.mu;
  law_.lambda = lame.lambda;
  law_.m = 4.0 / 3 * law_.mu;
  law_.k = law_.lambda + 5.0 / 6 * law_.mu;
  std::vector<TetGeometry> geometry;
  for (const auto& tet : corners_) geometry.push_back(GeometryOf(nodes, tet));
  groups_.resize((corners_.size() + kLanes - 1) / kLanes);
  for (std::size_t t = 0; t < kLanes * groups_.size(); ++t) {
    Group& group = groups_[t / kLanes];
    const std::size_t l = t % kLanes, from = t < corners_.size() ? t : t - l;
    for (std::size_t a = 0; a < 4; ++a) group.node[a][l] = 3 * corners_[from][a];
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t c = 0; c < 3; ++c) {
        group.gradient[a][c][l] = geometry[from].grad(static_cast<int>(c), static_cast<int>(a + 1));
      }
    }
    const double modulus = moduli.empty() ? 1 : moduli[from];
    group.volume[l] = t < corners_.size() ? modulus * geometry[t].volume : 0;
  }
}

void NeoHookeanTets::AddForce(const double* u, double* force) const noexcept {
  AddForces(law_, groups_.data(), groups_.size(), u, force);
}

double NeoHookeanTets::AddNonlinearForce(const double* u, double* force) const noexcept {
  return AddNonlinearForces(law_, groups_.data(), groups_.size(), u, force);
}

}  // namespace palpate
