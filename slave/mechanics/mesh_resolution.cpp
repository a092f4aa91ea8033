#include "slave/mechanics/mesh_resolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

constexpr double kMostOff = 0.1;
constexpr int kFewest = 3;  // pieces that may stand for a disc with a rim

constexpr double kNoRim = 1e-6;

// c of PatchStiffness: what moves or loads less than it touches is softer, what spreads its load
// over the elements around is stiffer.
double RimEffect(PatchBasis basis) {
  switch (basis) {
    case PatchBasis::kMovedNodes:
      return -0.05;
    case PatchBasis::kMovedNodes10:
      return -0.25;
    case PatchBasis::kLoadedTriangles:
      return 0.9;
    case PatchBasis::kLoadedTriangles10:
      return 0.3;
    case PatchBasis::kTractionTriangles:
      break;
  }
  return -0.15;
}

bool IsOfNodes(PatchBasis basis) {
  return basis == PatchBasis::kMovedNodes || basis == PatchBasis::kMovedNodes10;
}

}  // namespace

PatchCover CoverOf(const SurfacePatch& patch, PatchBasis basis) noexcept {
  if (IsOfNodes(basis)) {
    return {basis, patch.disc, patch.node_area, static_cast<int>(patch.nodes.size())};
  }
  return {basis, patch.disc, patch.triangle_area, static_cast<int>(patch.triangles.size())};
}

double PatchStiffness(const PatchCover& cover) noexcept {
  const double rim = std::clamp(cover.disc.rim / (2 * std::numbers::pi), 0.0, 1.0);
  const bool is_disc = cover.count >= kFewest || (cover.count > 0 && rim < kNoRim);
  if (!is_disc || !(cover.disc.area > 0)) return 0;
  return std::sqrt(cover.area / cover.disc.area) *
         (1 + rim * RimEffect(cover.basis) / std::sqrt(cover.count));
}

bool IsPatchCoarse(const PatchCover& cover) noexcept {
  return std::abs(PatchStiffness(cover) - 1) > kMostOff;
}

}  // namespace palpate
