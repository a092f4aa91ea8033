// What a unit force on the free surface of a fixed body does to every place of it: the Green's
// functions that contacts in 3D are answered with (James and Pai 2003; paper A, eqs. 5-7, in the
// form of a compliance: a surface that is free of traction in the reference problem needs no other
// block of E); and the forces that contacts must find, with the blocks of a compliance between
// them.
//
// Nondimensional: lengths by length_unit(), forces by E times its square.
#pragma once

#include <array>

#include <Eigen/Core>

#include "shared/geometry/index.h"
#include "slave/mechanics/footprint/contact_footprint.h"

namespace palpate {

class Compliance {
 public:
  virtual ~Compliance() = default;
  Compliance() = default;
  Compliance(const Compliance&) = delete;
  Compliance& operator=(const Compliance&) = delete;

  // Points of contact, called places: surface nodes.
  [[nodiscard]] virtual int places() const = 0;
  // Betti: block(i, j) = block(j, i)^T to working precision. Then contacts are factorised by
  // Cholesky's method.
  [[nodiscard]] virtual bool symmetric() const = 0;
  // 9 numbers per place i: entry 3 c + r is the displacement along r at i by a unit force along c
  // at `place`. Columns may be computed at the first request, which needs milliseconds and memory;
  // never nullptr. The pointer stays valid.
  virtual const double* Column(int place) = 0;
  [[nodiscard]] virtual double length_unit() const = 0;  // [m]
  [[nodiscard]] virtual std::size_t memory_bytes() const = 0;
};

// An unknown force, distributed over at most three places; frame O, nondimensional.
struct ForceUnknown {
  struct Share {
    const double* column = nullptr;  // of the compliance
    int place = -1;
    double weight = 0;
  };
  std::array<Share, kMostPointPlaces> shares;
  int share_count = 0;
  int row = 0;         // of its first component in the capacitance matrix
  int count = 3;       // components that are unknown
  bool plain = false;  // one place, all components
  Eigen::Matrix3d basis = Eigen::Matrix3d::Identity();  // columns 0 to count: their directions
};

// The block of the compliance at a place of one share by a unit force at a place of another.
inline Eigen::Map<const Eigen::Matrix3d> BlockAt(const double* column, int place) {
  return Eigen::Map<const Eigen::Matrix3d>(column + 9 * static_cast<long>(place));
}

// Weighted displacement at the places of `at` by unit forces `by`, all three components.
inline Eigen::Matrix3d FullBlock(const ForceUnknown& at, const ForceUnknown& by) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int b = 0; b < by.share_count; ++b) {
    const auto& from = by.shares[Index(b)];
    for (int a = 0; a < at.share_count; ++a) {
      const auto& to = at.shares[Index(a)];
      sum += to.weight * from.weight * BlockAt(from.column, to.place);
    }
  }
  return sum;
}

// What two unknowns' components have of a block.
inline void CopyBlock(const ForceUnknown& at, const ForceUnknown& by, const Eigen::Matrix3d& block,
                      double* to, int stride) {
  for (int r = 0; r < at.count; ++r, to += stride) {
    for (int c = 0; c < by.count; ++c) to[c] = block(r, c);
  }
}

// The capacitance matrix's rows and columns of two unknowns: `to` is the entry at their first rows.
inline void FillBlock(const ForceUnknown& at, const ForceUnknown& by, double* to, int stride) {
  if (at.plain && by.plain) {
    const double* from = by.shares[0].column + 9 * static_cast<long>(at.shares[0].place);
    for (int r = 0; r < 3; ++r, to += stride) {
      to[0] = from[r];
      to[1] = from[3 + r];
      to[2] = from[6 + r];
    }
    return;
  }
  CopyBlock(at, by, at.basis.transpose() * FullBlock(at, by) * by.basis, to, stride);
}

// The same where the compliance is symmetric, from the column of `at`.
inline void FillBlockBySymmetry(const ForceUnknown& at, const ForceUnknown& by, double* to,
                                int stride) {
  if (at.plain && by.plain) {
    const double* from = at.shares[0].column + 9 * static_cast<long>(by.shares[0].place);
    for (int r = 0; r < 3; ++r, to += stride, from += 3) {
      to[0] = from[0];
      to[1] = from[1];
      to[2] = from[2];
    }
    return;
  }
  CopyBlock(at, by, at.basis.transpose() * FullBlock(by, at).transpose() * by.basis, to, stride);
}

// The memory that FillBlock will read: big columns are far apart.
inline void PrefetchBlock(const ForceUnknown& at, const ForceUnknown& by) {
  const double* entry = by.shares[0].column + 9 * static_cast<long>(at.shares[0].place);
  __builtin_prefetch(entry);
  __builtin_prefetch(entry + 8);
}

}  // namespace palpate
