#include "slave/precompute/distributed_matrix.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "slave/precompute/scalapack.h"

namespace palpate {

ProcessGrid::ProcessGrid(int rows_wanted, int columns_wanted) {
  Cblacs_get(0, 0, &context_);
  Cblacs_gridinit(&context_, "Row", rows_wanted, columns_wanted);
  if (context_ >= 0) Cblacs_gridinfo(context_, &rows, &columns, &row, &column);
}

ProcessGrid ProcessGrid::Square(const Ranks& ranks) {
  int rows = static_cast<int>(std::sqrt(ranks.size()));
  while (ranks.size() % rows != 0) --rows;
  return {rows, ranks.size() / rows};
}

ProcessGrid::~ProcessGrid() {
  if (context_ >= 0) Cblacs_gridexit(context_);
}

ProcessGrid::ProcessGrid(ProcessGrid&& other) noexcept
    : rows(other.rows),
      columns(other.columns),
      row(other.row),
      column(other.column),
      context_(std::exchange(other.context_, -1)) {}

DistributedMatrix::DistributedMatrix(const ProcessGrid& grid, int rows, int columns, int row_block,
                                     int column_block)
    : grid_(grid) {
  const int zero = 0;
  const auto count = [&](int all, int block, int process, int processes) {
    return grid.has_me() ? numroc_(&all, &block, &process, &zero, &processes) : 0;
  };
  const int my_rows = count(rows, row_block, grid.row, grid.rows);
  const int my_columns = count(columns, column_block, grid.column, grid.columns);
  if (double{1} * my_rows * my_columns > std::numeric_limits<int>::max()) {
    throw std::invalid_argument("a matrix of " + std::to_string(rows) + " x " +
                                std::to_string(columns) +
                                " numbers: accepted is less than 2^31 of them on each rank, so "
                                "more ranks");
  }
  share_ = Eigen::MatrixXd::Zero(my_rows, my_columns);
  constexpr int kDense = 1;
  description_ = {kDense, grid.context(),      rows, columns, row_block, column_block, 0,
                  0,      std::max(1, my_rows)};
}

int DistributedMatrix::LocalRow(int row) const {
  const int block = description_[4];
  return row / (block * grid_.rows) * block + row % block;
}

bool DistributedMatrix::HasRow(int row) const {
  return row / description_[4] % grid_.rows == grid_.row;
}

void Copy(int rows, int columns, const DistributedMatrix& from, Entry first, DistributedMatrix* to,
          Entry at, const ProcessGrid& all) {
  Cpdgemr2d(rows, columns, from.share().data(), first.row + 1, first.column + 1, from.description(),
            to->data(), at.row + 1, at.column + 1, to->description(), all.context());
}

}  // namespace palpate
