// Forces that contacts must find, and the blocks of a compliance between them.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/capacitance/contact_places.h"

namespace palpate {

// An unknown force, shared out over at most three places; frame O, nondimensional.
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

// The block of the compliance at a share's place by a unit force at another's.
inline Eigen::Map<const Eigen::Matrix3d> BlockAt(const double* column, int place) {
  return Eigen::Map<const Eigen::Matrix3d>(column + 9 * static_cast<long>(place));
}

// Displacement, weighted, at the places of `at` by unit forces `by`, all three components.
Eigen::Matrix3d FullBlock(const ForceUnknown& at, const ForceUnknown& by);

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
  const Eigen::Matrix3d block = at.basis.transpose() * FullBlock(at, by) * by.basis;
  for (int r = 0; r < at.count; ++r, to += stride) {
    for (int c = 0; c < by.count; ++c) to[c] = block(r, c);
  }
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
  const Eigen::Matrix3d block = at.basis.transpose() * FullBlock(by, at).transpose() * by.basis;
  for (int r = 0; r < at.count; ++r, to += stride) {
    for (int c = 0; c < by.count; ++c) to[c] = block(r, c);
  }
}

// The memory that FillBlock will read: big columns are far apart.
inline void PrefetchBlock(const ForceUnknown& at, const ForceUnknown& by) {
  const double* entry = by.shares[0].column + 9 * static_cast<long>(at.shares[0].place);
  __builtin_prefetch(entry);
  __builtin_prefetch(entry + 8);
}

}  // namespace palpate
