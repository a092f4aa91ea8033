// One problem of MUMPS, for the two factors that are made of it: mumps.h and
// slave/precompute/distributed_factor.h.
#pragma once

#include <vector>

#include <Eigen/SparseCore>
#include <dmumps_c.h>

namespace palpate {

struct Mumps {
  static constexpr int kPositiveDefinite = 1, kSymmetric = 2;
  static constexpr int kWorld = -987654;  // MPI_COMM_WORLD, also of the sequential library

  DMUMPS_STRUC_C data{};
  std::vector<int> rows, columns;  // counted from one
  std::vector<double> values;
  std::vector<int> positions;  // in the order of elimination, counted from one

  // All calls below are made by every rank of the communicator (Fortran's handle).
  explicit Mumps(int symmetry, int communicator = kWorld);
  ~Mumps() { Run(-2); }
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  int& Control(int number) { return data.icntl[number - 1]; }
  [[nodiscard]] int Info(int number) const { return data.infog[number - 1]; }
  int Run(int job);
  void Add(int row, int column) {
    rows.push_back(row + 1);
    columns.push_back(column + 1);
  }
  void Add(const Eigen::SparseMatrix<double>& lower);
  // The rows in the order of elimination, on the first rank; without it the library chooses.
  void EliminateAs(const std::vector<int>& order);
  // Of the entries added; `distributed`: those of all ranks are added up. Throws: see SpdFactor.
  void Analyse(int order, bool distributed = false);
  // `relaxation`: of the estimated workspace, to begin with [%].
  void FactoriseDefinite(int relaxation = 30);
  // In place, on the first rank.
  void Solve(double* right_sides, int count);
  void Require(int outcome) const;
};

}  // namespace palpate
