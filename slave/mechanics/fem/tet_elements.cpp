#include "slave/mechanics/fem/tet_elements.h"

#include <cmath>

#include "slave/mechanics/fem/neo_hookean_lanes.h"
#include "slave/mechanics/fem/signed_polar.h"
#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

constexpr int kNewtonSteps = 8;
// Square of the last rotation step below which iteration stops, since convergence is quadratic.
constexpr double kTurned = 1e-16;
constexpr double kDefinite = 1e-9;  // smallest det H relative to tr(H)^3 (1/27 at rest)

PALPATE_INLINE bool Any(const Mask8& mask) {
  long long any = 0;
  for (int l = 0; l < kLanes; ++l) any |= mask[l];
  return any != 0;
}

PALPATE_INLINE LaneQuaternion Turned(const LaneQuaternion& q, const Double8& x, const Double8& y,
                                     const Double8& z) {
  const LaneQuaternion t{q.s - q.x * x - q.y * y - q.z * z, q.x + q.s * x + q.y * z - q.z * y,
                         q.y + q.s * y + q.z * x - q.x * z, q.z + q.s * z + q.x * y - q.y * x};
  const Double8 n = 1.5 - 0.5 * (t.s * t.s + t.x * t.x + t.y * t.y + t.z * t.z);
  return {t.s * n, t.x * n, t.y * n, t.z * n};
}

// One step of Newton's method. `open`: lanes that have not converged; `wrong`: lanes where H is not
// positive definite. A rotation by d / (2 + d^2 / 2) equals the exact half-angle to third order and
// is bounded.
PALPATE_INLINE LaneQuaternion NewtonTurn(const LaneQuaternion& q, const Lanes3x3& G, Mask8& open,
                                         Mask8& wrong) {
  const Lanes3x3 E = StretchMinusIdentity(RotationMinusIdentity(q), G);
  const Double8 wx = E[2][1] - E[1][2], wy = E[0][2] - E[2][0], wz = E[1][0] - E[0][1];
  const Double8 h00 = 2 + E[1][1] + E[2][2], h11 = 2 + E[2][2] + E[0][0],
                h22 = 2 + E[0][0] + E[1][1];
  const Double8 h01 = -0.5 * (E[0][1] + E[1][0]), h12 = -0.5 * (E[1][2] + E[2][1]),
                h20 = -0.5 * (E[2][0] + E[0][2]);
  const Double8 a00 = h11 * h22 - h12 * h12, a01 = h12 * h20 - h01 * h22,
                a02 = h01 * h12 - h11 * h20;
  const Double8 a11 = h22 * h00 - h20 * h20, a12 = h20 * h01 - h12 * h00,
                a22 = h00 * h11 - h01 * h01;
  const Double8 det = h00 * a00 + h01 * a01 + h20 * a02;
  const Double8 trace = h00 + h11 + h22;
  wrong = ~((trace > 0) & (a22 > 0) & (h00 > 0) & (det > kDefinite * trace * trace * trace));
  const Double8 inverse = 1.0 / (wrong ? det * 0 + 1 : det);
  const Double8 dx = (a00 * wx + a01 * wy + a02 * wz) * inverse;
  const Double8 dy = (a01 * wx + a11 * wy + a12 * wz) * inverse;
  const Double8 dz = (a02 * wx + a12 * wy + a22 * wz) * inverse;
  const Double8 square = dx * dx + dy * dy + dz * dz;
  open = ~(square < kTurned);
  const Double8 half = 1.0 / (2 + 0.5 * square);
  return Turned(q, half * dx, half * dy, half * dz);
}

// Processes lanes for which Newton's method did not converge, one by one. `used`, because clang 16
// drops functions that only clones call.
[[gnu::noinline, gnu::used]] void TurnOneByOne(const Lanes3x3& G, const Mask8& unsure,
                                               LaneQuaternion& q) {
  for (int l = 0; l < kLanes; ++l) {
    if (!unsure[l]) continue;
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) F(i, j) += G[Index(i)][Index(j)][l];
    }
    const Eigen::Vector4d found = SignedPolarQuaternion(F);
    q.s[l] = found[0], q.x[l] = found[1], q.y[l] = found[2], q.z[l] = found[3];
  }
}

PALPATE_INLINE LaneQuaternion SignedPolar(LaneQuaternion q, const Lanes3x3& G) {
  Mask8 open{}, wrong{};
  for (int step = 0; step < kNewtonSteps; ++step) {
    q = NewtonTurn(q, G, open, wrong);
    if (!Any(open & ~wrong)) break;
  }
  if (Any(open | wrong)) TurnOneByOne(G, open | wrong, q);
  return q;
}

PALPATE_INLINE Lanes3x3 GradientOf(const TetGroup& group, const NodeValue* u) {
  std::array<std::array<Double8, 3>, 4> corner;
  for (std::size_t a = 0; a < 4; ++a) {
    for (int l = 0; l < kLanes; ++l) {
      const double* value = u[group.node[a][Index(l)]].v;
      for (std::size_t c = 0; c < 3; ++c) corner[a][c][l] = value[c];
    }
  }
  Lanes3x3 G;
  for (std::size_t i = 0; i < 3; ++i) {
    const Double8 d1 = corner[1][i] - corner[0][i], d2 = corner[2][i] - corner[0][i],
                  d3 = corner[3][i] - corner[0][i];
    for (std::size_t j = 0; j < 3; ++j) {
      G[i][j] = d1 * group.gradient[0][j] + d2 * group.gradient[1][j] + d3 * group.gradient[2][j];
    }
  }
  return G;
}

// Adds eight vectors per corner; those of the first corner are minus the sum of the others.
PALPATE_INLINE void Scatter(const std::array<std::array<Double8, 3>, 3>& of, NodeValue* out) {
  std::array<std::array<Double8, 3>, 4> corner;
  for (std::size_t c = 0; c < 3; ++c) {
    corner[0][c] = -(of[0][c] + of[1][c] + of[2][c]);
    for (std::size_t a = 1; a < 4; ++a) corner[a][c] = of[a - 1][c];
  }
  for (int l = 0; l < kLanes; ++l) {
    for (std::size_t a = 0; a < 4; ++a) {
      Store4(out[4 * Index(l) + a].v,
             Double4{corner[a][0][l], corner[a][1][l], corner[a][2][l], 0});
    }
  }
}

// Returns v + Q v for the three gradients, multiplied by a weight.
PALPATE_INLINE std::array<std::array<Double8, 3>, 3> Applied(
    const Lanes3x3& Q, const std::array<std::array<Double8, 3>, 3>& g, const Double8& weight,
    bool plus_identity) {
  std::array<std::array<Double8, 3>, 3> out;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      Double8 sum = Q[i][0] * g[a][0] + Q[i][1] * g[a][1] + Q[i][2] * g[a][2];
      if (plus_identity) sum += g[a][i];
      out[a][i] = sum * weight;
    }
  }
  return out;
}

struct Output {
  NodeValue *forces, *gradients;
};

PALPATE_INLINE Lanes3x3 StressOf(const Lanes3x3& Q, const Lanes3x3& E, const Lame& lame,
                                 Double8& energy) {
  const Double8 trace = E[0][0] + E[1][1] + E[2][2];
  Lanes3x3 T;
  Double8 squares{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const Double8 strain = 0.5 * (E[i][j] + E[j][i]);
      squares += strain * strain;
      T[i][j] = 2 * lame.mu * strain;
    }
    T[i][i] += lame.lambda * trace;
  }
  energy = lame.mu * squares + 0.5 * lame.lambda * trace * trace;
  Lanes3x3 P;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      P[i][j] = T[i][j] + Q[i][0] * T[0][j] + Q[i][1] * T[1][j] + Q[i][2] * T[2][j];
    }
  }
  return P;
}

PALPATE_INLINE Double8 Determinant(const Lanes3x3& G) {
  const Double8 a = 1 + G[0][0], b = 1 + G[1][1], c = 1 + G[2][2];
  return a * (b * c - G[1][2] * G[2][1]) - G[0][1] * (G[1][0] * c - G[1][2] * G[2][0]) +
         G[0][2] * (G[1][0] * G[2][1] - b * G[2][0]);
}

PALPATE_DISPATCHED void EvaluateGroups(TetGroup* groups, const NodeValue* u, const Lame& lame,
                                       bool rotating, const Output& out, int count) {
  for (int g = 0; g < count; ++g) {
    TetGroup& group = groups[g];
    const Lanes3x3 G = GradientOf(group, u);
    Lanes3x3 Q{};
    if (rotating) {
      auto& [s, x, y, z] = group.quaternion;
      const LaneQuaternion q = SignedPolar({s, x, y, z}, G);
      s = q.s, x = q.x, y = q.y, z = q.z;
      Q = RotationMinusIdentity(q);
    }
    const Lanes3x3 E = StretchMinusIdentity(Q, G);
    const Lanes3x3 P = StressOf(Q, E, lame, group.energy);
    group.energy *= group.volume;
    group.determinant = Determinant(G);
    const std::size_t at = 4 * kLanes * static_cast<std::size_t>(g);
    Scatter(Applied(P, group.gradient, group.volume, false), out.forces + at);
    if (rotating) {
      Scatter(Applied(Q, group.gradient, group.root_volume_mu, true), out.gradients + at);
    }
  }
}

// Four numbers of each of eight elements, element by element.
PALPATE_INLINE void Transpose(const Double8& a, const Double8& b, const Double8& c,
                              const Double8& d, std::array<Double4, kLanes>* of) {
  const Double8 ab0 = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
  const Double8 ab1 = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  const Double8 cd0 = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
  const Double8 cd1 = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
  (*of)[0] = __builtin_shufflevector(ab0, cd0, 0, 1, 8, 9);
  (*of)[1] = __builtin_shufflevector(ab1, cd1, 0, 1, 8, 9);
  (*of)[2] = __builtin_shufflevector(ab0, cd0, 2, 3, 10, 11);
  (*of)[3] = __builtin_shufflevector(ab1, cd1, 2, 3, 10, 11);
  (*of)[4] = __builtin_shufflevector(ab0, cd0, 4, 5, 12, 13);
  (*of)[5] = __builtin_shufflevector(ab1, cd1, 4, 5, 12, 13);
  (*of)[6] = __builtin_shufflevector(ab0, cd0, 6, 7, 14, 15);
  (*of)[7] = __builtin_shufflevector(ab1, cd1, 6, 7, 14, 15);
}

// Adds the block of one pair of corners of eight elements. Neighbouring elements add to the same
// block. A number is always written and read together with the same others, because otherwise the
// processor waits for the memory.
PALPATE_INLINE void AddBlocks(const std::array<int, kLanes>& blocks, const Lanes3x3& K,
                              double* values) {
  std::array<Double4, kLanes> first, second;
  Transpose(K[0][0], K[1][0], K[2][0], K[0][1], &first);
  Transpose(K[1][1], K[2][1], K[0][2], K[1][2], &second);
#pragma GCC unroll 8
  for (int l = 0; l < kLanes; ++l) {
    double* to = values + 9 * static_cast<std::ptrdiff_t>(blocks[Index(l)]);
    Store4(to, Load4(to) + first[Index(l)]);
    Store4(to + 4, Load4(to + 4) + second[Index(l)]);
    to[8] += K[2][2][l];
  }
}

PALPATE_INLINE NeoHookeanPoint EvaluateNeoHookean(const NeoHookeanModuli& law, TetGroup& group,
                                                  const NodeValue* u, NodeValue* forces) {
  const NeoHookeanPoint at = NeoHookeanAt(law, GradientOf(group, u));
  group.energy = group.volume * at.energy;
  group.determinant = at.determinant;
  Scatter(Applied(at.stress, group.gradient, group.volume, false), forces);
  return at;
}

PALPATE_DISPATCHED void EvaluateHyperelastic(TetGroup* groups, const NodeValue* u,
                                             const NeoHookeanModuli& law, NodeValue* forces,
                                             int count) {
  for (int g = 0; g < count; ++g) {
    EvaluateNeoHookean(law, groups[g], u, forces + 4 * kLanes * static_cast<std::size_t>(g));
  }
}

PALPATE_DISPATCHED void EvaluateTangents(TetGroup* groups, const NodeValue* u,
                                         const NeoHookeanModuli& law, NodeValue* forces,
                                         const TetElements::GroupBlocks* blocks,
                                         const TangentTarget& tangent, int count) {
  for (int g = 0; g < count; ++g) {
    TetGroup& group = groups[g];
    const NeoHookeanPoint at =
        EvaluateNeoHookean(law, group, u, forces + 4 * kLanes * static_cast<std::size_t>(g));
    PairBlocks K;
    TangentOf(at, law.k, tangent.shift, group.gradient, group.volume, K);
    for (std::size_t pair = 0; pair < kPairs; ++pair) {
      AddBlocks(blocks[g][pair], K[pair], tangent.values);
    }
  }
}

NeoHookeanModuli ModuliOf(const Lame& lame) {
  return {4.0 / 3 * lame.mu, lame.lambda + 5.0 / 6 * lame.mu};
}

}  // namespace

TetElements::TetElements(const SolidMesh& mesh, const Lame& lame, Law law)
    : count_(static_cast<int>(mesh.tets.size())),
      lame_(lame),
      law_(law),
      groups_((mesh.tets.size() + kLanes - 1) / kLanes),
      forces_(4 * kLanes * groups_.size()),
      gradients_(4 * kLanes * groups_.size()) {
  ForgetRotations();
  for (int e = 0; e < count_; ++e) {
    TetGroup& group = groups_[Index(e / kLanes)];
    const int l = e % kLanes;
    const auto& tet = mesh.tets[Index(e)];
    const TetGeometry geometry = GeometryOf(mesh.nodes, tet);
    const double volume = std::abs(geometry.volume) * mesh.ModulusOf(Index(e));
    const double root = std::sqrt(volume * lame.mu);
    for (int a = 0; a < 4; ++a) {
      group.node[Index(a)][Index(l)] = tet[Index(a)];
      for (int c = 0; c < 3; ++c) {
        if (a > 0) group.gradient[Index(a) - 1][Index(c)][l] = geometry.grad(c, a);
        gradients_[4 * Index(e) + Index(a)].v[c] = root * geometry.grad(c, a);
      }
    }
    group.volume[l] = volume;
    group.root_volume_mu[l] = root;
  }
}

void TetElements::ForgetRotations() noexcept {
  for (auto& group : groups_) group.quaternion = {Double8{} + 1, Double8{}, Double8{}, Double8{}};
}

ElementSummary TetElements::Evaluate(const NodeVector& u) noexcept {
  const Output out{forces_.data(), gradients_.data()};
  if (law_ == Law::kNeoHookean) {
    EvaluateHyperelastic(groups_.data(), u.data(), ModuliOf(lame_), out.forces, groups());
  } else {
    EvaluateGroups(groups_.data(), u.data(), lame_, law_ == Law::kCorotational, out, groups());
  }
  return Summary();
}

ElementSummary TetElements::EvaluateWithTangent(const NodeVector& u,
                                                std::span<const GroupBlocks> blocks,
                                                const TangentTarget& tangent) noexcept {
  EvaluateTangents(groups_.data(), u.data(), ModuliOf(lame_), forces_.data(), blocks.data(),
                   tangent, groups());
  return Summary();
}

ElementSummary TetElements::Summary() const noexcept {
  ElementSummary summary;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    for (int l = 0; l < kLanes; ++l) {
      summary.energy += groups_[g].energy[l];
      if (groups_[g].determinant[l] > 0) continue;
      const int element = kLanes * static_cast<int>(g) + l;
      if (summary.inverted++ == 0) summary.first_inverted = element;
    }
  }
  return summary;
}

}  // namespace palpate::fem
