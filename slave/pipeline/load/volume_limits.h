// Limits of the search for a load on a volume.
#pragma once

namespace palpate {

struct VolumeLimits {
  // Points of a load [-]. [derived: three nodal forces, and one to spare]
  static constexpr int kMinPoints = 4;
  // Largest number of solutions for new points times their unknowns per sample, beyond a first
  // point: otherwise the states of a large body would stop for seconds [-]. [measured: 3.6 ms per
  // solution of 20,250 tetrahedra, 30 ms in total]
  static constexpr double kWork = 1e5;
  // Positions with a smaller distance, relative to that from the origin, are the same [-].
  // [derived: rounding]
  static constexpr double kSamePlace = 1e-9;
  // Number of nodes whose triangles are searched [-].
  static constexpr int kBestNodes = 6;
  // Load of a linear response, divided by E times the square of the larger side [-]. [derived: a
  // strain of a millionth]
  static constexpr double kLinearLoad = 1e-6;
  // Smallest width of a load relative to the larger side [-].
  static constexpr double kMinWidth = 1e-3;
  // Residual below which the stated sigmas are too large, and by how much they may be [-].
  // [derived: those of LoadFitter]
  static constexpr double kTrusted = 0.7, kMinResidual = 0.1;
  // Rounds of leaving points out, and Newton steps of the load through a model that is not linear
  // [-]. [tuned: volume_load_identifier_test]
  static constexpr int kRounds = 5;
  // Change of the load at which the Newton steps end, relative to the load and to its sigma [-].
  static constexpr double kRefined = 1e-4, kOfSigma = 0.05;
  // Smallest slope (change of a Newton step per change of the load) for a secant step, and largest
  // change by a secant step relative to the load [-]. [derived: -1 where the model is linear]
  static constexpr double kMinSlope = 0.1, kMaxChange = 0.5;
  // Models whose displacements under a load differ by less, relative to their magnitude, are the
  // same [-].
  static constexpr double kSameModel = 1e-3;
};

}  // namespace palpate
