// Dense matrices of which every rank has a share, in blocks dealt out in turn to the processes of a
// grid (ScaLAPACK Users' Guide, 1997, sec. 4.3).
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/precompute/ranks.h"

namespace palpate {

// A grid of processes. Ranks beyond its size are outside of it.
class ProcessGrid {
 public:
  ProcessGrid(int rows, int columns);
  // As square as the number of ranks allows.
  static ProcessGrid Square(const Ranks& ranks);
  ~ProcessGrid();
  ProcessGrid(ProcessGrid&& other) noexcept;
  ProcessGrid(const ProcessGrid&) = delete;
  ProcessGrid& operator=(const ProcessGrid&) = delete;
  ProcessGrid& operator=(ProcessGrid&&) = delete;

  [[nodiscard]] bool has_me() const { return row >= 0; }
  [[nodiscard]] int context() const { return context_; }

  int rows = 0, columns = 0;  // of the grid
  int row = -1, column = -1;  // of this rank

 private:
  int context_ = -1;
};

class DistributedMatrix {
 public:
  // Zero. `row_block`, `column_block`: size of the blocks. Throws std::invalid_argument: this
  // rank's share is more than ScaLAPACK's indices reach. The grid must live longer.
  DistributedMatrix(const ProcessGrid& grid, int rows, int columns, int row_block,
                    int column_block);

  [[nodiscard]] int rows() const { return description_[2]; }
  [[nodiscard]] int columns() const { return description_[3]; }
  [[nodiscard]] const int* description() const { return description_.data(); }
  [[nodiscard]] const ProcessGrid& grid() const { return grid_; }
  // This rank's share.
  [[nodiscard]] Eigen::MatrixXd& share() { return share_; }
  [[nodiscard]] const Eigen::MatrixXd& share() const { return share_; }
  [[nodiscard]] double* data() { return share_.data(); }
  // Where a row stands in the share of the process that has it, and whether that is this one.
  [[nodiscard]] int LocalRow(int row) const;
  [[nodiscard]] bool HasRow(int row) const;

 private:
  const ProcessGrid& grid_;
  std::array<int, 9> description_{};
  Eigen::MatrixXd share_;
};

struct Entry {
  int row = 0, column = 0;  // from zero
};
// Copies rows x columns numbers between matrices of any distribution. `all`: a grid of all ranks.
void Copy(int rows, int columns, const DistributedMatrix& from, Entry first, DistributedMatrix* to,
          Entry at, const ProcessGrid& all);

}  // namespace palpate
