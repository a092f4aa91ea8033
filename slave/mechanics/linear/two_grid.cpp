#include "slave/mechanics/linear/two_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <lapacke.h>

#include "slave/mechanics/linear/lanes.h"
#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

using Eigen::Vector3d;

constexpr int kNodesPerVertex = 27;  // fine nodes per coarse vertex: three along each axis
constexpr int kMaxVertices = 2000;   // largest coarse grid whose band matrix fits in the cache
constexpr double kFiner = 1.05;      // ratio of successive trial grids
constexpr double kMinShift = 1e-9;   // of the coarse diagonal, for corners that few nodes share
constexpr double kMaxShift = 1e-4;

using Float4 [[gnu::vector_size(16), gnu::may_alias, gnu::aligned(4)]] = float;

PALPATE_INLINE Float4 Load(const float* p) {
  return *reinterpret_cast<const Float4*>(p);
}
PALPATE_INLINE void Store(float* p, const Float4& values) {
  *reinterpret_cast<Float4*>(p) = values;
}
PALPATE_INLINE Float4 Times(const float* block, const float* x) {
  return Load(block) * x[0] + Load(block + 3) * x[1] + Load(block + 6) * x[2];
}
// Returns the sum of the blocks [first, last) times x of their columns.
PALPATE_INLINE Float4 Product(const int* column, const float* values, int first, int last,
                              const float* x) {
  Float4 sum0{}, sum1{}, sum2{};
  for (int k = first; k < last; ++k) {
    const float* block = values + 9 * static_cast<std::size_t>(k);
    const float* xj = x + 4 * static_cast<std::size_t>(column[k]);
    sum0 += Load(block) * xj[0];
    sum1 += Load(block + 3) * xj[1];
    sum2 += Load(block + 6) * xj[2];
  }
  return sum0 + sum1 + sum2;
}

// Solves (D + L) z = r from z = 0, and computes the remaining residual.
PALPATE_DISPATCHED void SweepForward(const int* begin, const int* column, const int* diagonal,
                                     const float* values, const float* inverse, int rows,
                                     const float* r, float* z, float* left) {
  for (int i = 0; i < rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    float rest[4];
    Store(rest, Load(r + 4 * at) - Product(column, values, begin[i], diagonal[i], z));
    Store(z + 4 * at, Times(inverse + 9 * at, rest));
  }
  for (int i = 0; i < rows; ++i) {
    const auto at = 4 * static_cast<std::size_t>(i);
    Store(left + at, -Product(column, values, diagonal[i] + 1, begin[i + 1], z));
  }
}

PALPATE_DISPATCHED void SweepBackward(const int* begin, const int* column, const int* diagonal,
                                      const float* values, const float* inverse, int rows,
                                      const float* r, float* z) {
  for (int i = rows - 1; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    float rest[4];
    Store(rest, Load(r + 4 * at) - Product(column, values, begin[i], diagonal[i], z) -
                    Product(column, values, diagonal[i] + 1, begin[i + 1], z));
    Store(z + 4 * at, Times(inverse + 9 * at, rest));
  }
}

// coarse += P^T left, of the free components.
PALPATE_DISPATCHED void Restrict(const GridPlace* places, const NodeValue* free, const float* left,
                                 std::size_t rows, NodeValue* coarse) {
  for (std::size_t i = 0; i < rows; ++i) {
    const GridPlace& place = places[i];
    const float* x = left + 4 * i;
    const Double4 value = Load4(free[i].v) * Double4{x[0], x[1], x[2], 0};
    for (std::size_t b = 0; b < 8; ++b) {
      double* sum = coarse[place.vertex[b]].v;
      Store4(sum, Load4(sum) + place.weight[b] * value);
    }
  }
}

// z += P coarse, of the free components.
PALPATE_DISPATCHED void Prolongate(const GridPlace* places, const NodeValue* free,
                                   const NodeValue* coarse, std::size_t rows, float* z) {
  for (std::size_t i = 0; i < rows; ++i) {
    const GridPlace& place = places[i];
    Double4 sum{};
    for (std::size_t b = 0; b < 8; ++b) sum += place.weight[b] * Load4(coarse[place.vertex[b]].v);
    Store(z + 4 * i, Load(z + 4 * i) + __builtin_convertvector(Load4(free[i].v) * sum, Float4));
  }
}

struct FineMatrix {
  const int *begin, *column;
  const double* values;
  const NodeValue* free;
  const GridPlace* places;
  double scale;
};

// Copies the coupling of free components, scaled to about one, to blocks with space for one more
// number.
PALPATE_DISPATCHED void CopyFree(const FineMatrix& A, int rows, float* blocks) {
  for (int row = 0; row < rows; ++row) {
    const Double4 free_row = A.scale * Load4(A.free[row].v);
    for (int k = A.begin[row]; k < A.begin[row + 1]; ++k) {
      const std::size_t at = 9 * static_cast<std::size_t>(k);
      const double* free_column = A.free[A.column[k]].v;
      for (std::size_t c = 0; c < 3; ++c) {
        const Double4 column = free_column[c] * free_row * Load4(A.values + at + 3 * c);
        Store(blocks + at + 3 * c, __builtin_convertvector(column, Float4));
      }
    }
  }
}

struct CoarseRow {
  // Vertices of one row of the fine grid; for each vertex its slot there, or -1.
  int *vertex, *slot;
  NodeValue* sums;  // three columns each
};

// Adds P_i^T A_i P of each row of the fine grid to a lower band matrix stored by columns, with
// padding of three numbers.
PALPATE_DISPATCHED void AddCoarse(const FineMatrix& A, int rows, const CoarseRow& near, int band,
                                  double* coarse) {
  for (int row = 0; row < rows; ++row) {
    const Double4 free_row = A.scale * Load4(A.free[row].v);
    const GridPlace& here = A.places[row];
    int count = 0;
    for (int k = A.begin[row]; k < A.begin[row + 1]; ++k) {
      const double* from = A.values + 9 * static_cast<std::size_t>(k);
      const double* free_column = A.free[A.column[k]].v;
      const GridPlace& there = A.places[A.column[k]];
      Double4 block[3];
      for (int c = 0; c < 3; ++c) block[c] = free_column[c] * free_row * Load4(from + 3 * c);
      for (std::size_t b = 0; b < 8; ++b) {
        int& slot = near.slot[there.vertex[b]];
        if (slot < 0) {
          slot = count++;
          near.vertex[slot] = there.vertex[b];
          for (int c = 0; c < 3; ++c) near.sums[3 * slot + c] = {};
        }
        for (int c = 0; c < 3; ++c) {
          double* sum = near.sums[3 * slot + c].v;
          Store4(sum, Load4(sum) + there.weight[b] * block[c]);
        }
      }
    }
    for (int n = 0; n < count; ++n) {
      const int vertex = near.vertex[n];
      near.slot[vertex] = -1;
      for (std::size_t a = 0; a < 8; ++a) {
        if (here.vertex[a] < vertex || here.weight[a] == 0) continue;
        for (int c = 0; c < 3; ++c) {
          const double* sum = near.sums[3 * n + c].v;
          double* to =
              coarse + static_cast<std::ptrdiff_t>(3 * vertex + c) * band + (3 * here.vertex[a]);
          if (here.vertex[a] > vertex) {
            Store4(to, Load4(to) + here.weight[a] * Load4(sum));
          } else {
            for (int r = c; r < 3; ++r) to[r] += here.weight[a] * sum[r];
          }
        }
      }
    }
  }
}

// Cubes along each axis, about as long as `side`.
Eigen::Array3i CellsOf(const Vector3d& extent, double side) {
  return (extent / side).array().round().max(1).min(1000).cast<int>();
}

// Returns the cell that contains a place in the unit box, and the place's coordinates within the
// cell.
Eigen::Array3i CellAt(const Vector3d& place, const Eigen::Array3i& cells, Vector3d* within) {
  const Eigen::Array3d at = place.array() * cells.cast<double>();
  const Eigen::Array3i cell = at.floor().cast<int>().max(0).min(cells - 1);
  *within = (at - cell.cast<double>()).matrix();
  return cell;
}

// Corner `corner` of a cube; the last axis counts slowest.
int VertexOf(const Eigen::Array3i& cell, const Eigen::Array3i& cells, int corner) {
  const Eigen::Array3i at = cell + Eigen::Array3i(corner & 1, (corner >> 1) & 1, corner >> 2);
  return at[0] + (cells[0] + 1) * (at[1] + (cells[1] + 1) * at[2]);
}

}  // namespace

TwoGrid::TwoGrid(std::span<const Vector3d> points, const BlockPattern& pattern)
    : pattern_(pattern),
      places_(points.size()),
      free_(points.size()),
      coarse_free_(points.size()),
      values_(9 * Index(pattern.blocks()) + 1),
      inverse_(9 * points.size() + 1),
      r_(points.size()),
      z_(points.size()),
      left_(points.size()) {
  FindGrid(points, std::clamp(pattern.rows() / kNodesPerVertex, 8, kMaxVertices));
  int widest = 0;
  for (const GridPlace& place : places_) {
    const auto [least, most] = std::ranges::minmax(place.vertex);
    widest = std::max(widest, most - least);
  }
  for (int row = 0; row < pattern.rows(); ++row) {
    for (const int column : pattern.graph.of(row)) {
      for (const int a : places_[Index(row)].vertex) {
        for (const int b : places_[Index(column)].vertex) widest = std::max(widest, a - b);
      }
    }
  }
  band_ = std::min(3 * widest + 2, 3 * vertices_ - 1);
  coarse_.resize(Index(3 * vertices_) * Index(band_ + 1) + 3);
  coarse_r_.resize(Index(3 * vertices_));
  coarse_nodes_.resize(Index(vertices_));
  slot_.assign(Index(vertices_), -1);
  near_.resize(Index(vertices_));
  sums_.resize(Index(3 * vertices_));
}

// Finds the finest grid around the body with at most this number of vertices.
void TwoGrid::FindGrid(std::span<const Vector3d> points, int most) {
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(p);
  std::array<int, 3> axes{0, 1, 2};
  const Vector3d sizes = box.sizes();
  std::ranges::sort(axes, [&](int a, int b) { return sizes[a] < sizes[b]; });
  const Vector3d sorted(sizes[axes[0]], sizes[axes[1]], sizes[axes[2]]);
  const Vector3d extent = sorted.cwiseMax(1e-12 * sorted[2]).cwiseMax(1e-300);
  const auto place_of = [&](std::size_t i) -> Vector3d {
    const Vector3d p = points[i] - box.min();
    return Vector3d(p[axes[0]], p[axes[1]], p[axes[2]]).cwiseQuotient(extent);
  };
  std::vector<int> used;
  const auto find_used = [&](const Eigen::Array3i& cells) {
    used.clear();
    Vector3d within;
    for (std::size_t i = 0; i < points.size(); ++i) {
      used.push_back(VertexOf(CellAt(place_of(i), cells, &within), cells, 0));
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const std::size_t count = used.size();
    for (std::size_t i = 0; i < count; ++i) {
      for (int corner = 1; corner < 8; ++corner) {
        used.push_back(used[i] + VertexOf(Eigen::Array3i::Zero(), cells, corner));
      }
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
  };
  Eigen::Array3i cells = CellsOf(extent, extent[2]);
  for (double side = extent[2]; (cells < 1000).all(); side /= kFiner) {
    const Eigen::Array3i finer = CellsOf(extent, side);
    if ((finer == cells).all()) continue;
    find_used(finer);
    if (static_cast<int>(used.size()) > most) break;
    cells = finer;
  }
  find_used(cells);
  vertices_ = static_cast<int>(used.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vector3d t;
    const Eigen::Array3i cell = CellAt(place_of(i), cells, &t);
    for (int corner = 0; corner < 8; ++corner) {
      const auto found = std::ranges::lower_bound(used, VertexOf(cell, cells, corner));
      places_[i].vertex[Index(corner)] = static_cast<int>(found - used.begin());
      places_[i].weight[Index(corner)] = ((corner & 1) != 0 ? t[0] : 1 - t[0]) *
                                         ((corner & 2) != 0 ? t[1] : 1 - t[1]) *
                                         ((corner & 4) != 0 ? t[2] : 1 - t[2]);
    }
  }
}

std::size_t TwoGrid::memory_bytes() const {
  return sizeof(double) * (coarse_.size() + coarse_r_.size()) + places_.size() * sizeof(GridPlace) +
         sizeof(float) * (values_.size() + inverse_.size()) + 2 * free_.size() * sizeof(NodeValue) +
         3 * r_.size() * sizeof(Single);
}

bool TwoGrid::Factor(const BlockMatrix& A, const NodeVector& free,
                     std::span<const Guide> guides) noexcept {
  double largest = 0;
  for (const int k : pattern_.diagonal) {
    const double* block = A.block(k);
    largest = std::max({largest, block[0], block[4], block[8]});
  }
  if (!(largest > 0) || !std::isfinite(largest)) return false;
  scale_ = 1 / largest;
  return Renew(A, free, guides) && FactorCoarse(A);
}

bool TwoGrid::CoarseFixes(const NodeVector& free) const noexcept {
  for (std::size_t i = 0; i < coarse_free_.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (coarse_free_[i].v[c] > free[i].v[c]) return false;
    }
  }
  return true;
}

bool TwoGrid::Renew(const BlockMatrix& A, const NodeVector& free,
                    std::span<const Guide> guides) noexcept {
  std::copy_n(free.begin(), free_.size(), free_.begin());
  CopyFree({pattern_.graph.begin.data(), pattern_.graph.column.data(), A.block(0), free_.data(),
            places_.data(), scale_},
           pattern_.rows(), values_.data());
  return InvertDiagonal(A) &&
         std::ranges::all_of(guides, [&](const Guide& guide) { return GuideRow(A, guide); });
}

// Applies Q = I - n n^T from both sides, and inverts in the remaining subspace.
bool TwoGrid::GuideRow(const BlockMatrix& A, const Guide& guide) noexcept {
  const Eigen::Matrix3d outer = guide.normal * guide.normal.transpose();
  const Eigen::Matrix3d Q = Eigen::Matrix3d::Identity() - outer;
  const Eigen::Matrix3f single = Q.cast<float>();
  const auto block_of = [&](int k) { return Eigen::Map<Eigen::Matrix3f>(&values_[9 * Index(k)]); };
  for (int k = pattern_.graph.begin[Index(guide.row)];
       k < pattern_.graph.begin[Index(guide.row) + 1]; ++k) {
    block_of(k) = (single * block_of(k)).eval();
    auto mirror = block_of(pattern_.transpose[Index(k)]);
    mirror = (mirror * single).eval();
  }
  const Eigen::Map<const Eigen::Matrix3d> block(A.block(pattern_.diagonal[Index(guide.row)]));
  const Eigen::Matrix3d among = scale_ * Q * block * Q + outer;
  if (!(among.determinant() > 0)) return false;
  Eigen::Map<Eigen::Matrix3f> kept(&inverse_[9 * Index(guide.row)]);
  kept = (Q * among.inverse() * Q).cast<float>();
  return true;
}

bool TwoGrid::InvertDiagonal(const BlockMatrix& A) noexcept {
  for (int i = 0; i < pattern_.rows(); ++i) {
    Eigen::Matrix3d block =
        scale_ * Eigen::Map<const Eigen::Matrix3d>(A.block(pattern_.diagonal[Index(i)]));
    const Eigen::Map<const Vector3d> free(At(free_, i).v);
    block = (free.asDiagonal() * block * free.asDiagonal()).eval();
    block.diagonal() += Vector3d::Ones() - free;
    const double determinant = block.determinant();
    const double minor = block(0, 0) * block(1, 1) - block(0, 1) * block(1, 0);
    if (!(block(0, 0) > 0) || !(minor > 0) || !(determinant > 0)) return false;
    const Eigen::Matrix3d inverse = block.inverse();
    Eigen::Map<Eigen::Matrix3f> kept(&inverse_[9 * Index(i)]);
    kept = (free.asDiagonal() * inverse * free.asDiagonal()).cast<float>();
  }
  return true;
}

bool TwoGrid::FactorCoarse(const BlockMatrix& A) noexcept {
  coarse_free_ = free_;
  for (double shift = kMinShift; shift <= kMaxShift; shift *= 1e5) {
    std::ranges::fill(coarse_, 0.0);
    AddCoarse({pattern_.graph.begin.data(), pattern_.graph.column.data(), A.block(0), free_.data(),
               places_.data(), scale_},
              pattern_.rows(), {near_.data(), slot_.data(), sums_.data()}, band_, coarse_.data());
    for (int i = 0; i < 3 * vertices_; ++i) {
      double& diagonal = Coarse(i, i);
      diagonal = diagonal > 0 ? (1 + shift) * diagonal : 1;
    }
    if (LAPACKE_dpbtrf_work(LAPACK_COL_MAJOR, 'L', 3 * vertices_, band_, coarse_.data(),
                            band_ + 1) == 0) {
      return true;
    }
  }
  return false;
}

void TwoGrid::CorrectCoarsely() noexcept {
  SetZero(coarse_nodes_);
  Restrict(places_.data(), free_.data(), left_.front().v, places_.size(), coarse_nodes_.data());
  for (std::size_t i = 0; i < coarse_r_.size(); ++i) coarse_r_[i] = coarse_nodes_[i / 3].v[i % 3];
  LAPACKE_dpbtrs_work(LAPACK_COL_MAJOR, 'L', 3 * vertices_, band_, 1, coarse_.data(), band_ + 1,
                      coarse_r_.data(), 3 * vertices_);
  for (std::size_t i = 0; i < coarse_r_.size(); ++i) coarse_nodes_[i / 3].v[i % 3] = coarse_r_[i];
  Prolongate(places_.data(), free_.data(), coarse_nodes_.data(), places_.size(), z_.front().v);
}

void TwoGrid::Solve(const NodeVector& r, NodeVector& z) noexcept {
  const int rows = pattern_.rows();
  const double size = Norm(r);
  if (!(size > 0)) {
    SetZero(z);
    return;
  }
  for (std::size_t i = 0; i < r_.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      r_[i].v[c] = static_cast<float>(free_[i].v[c] / size * r[i].v[c]);
    }
  }
  const auto& graph = pattern_.graph;
  SweepForward(graph.begin.data(), graph.column.data(), pattern_.diagonal.data(), values_.data(),
               inverse_.data(), rows, r_.front().v, z_.front().v, left_.front().v);
  CorrectCoarsely();
  SweepBackward(graph.begin.data(), graph.column.data(), pattern_.diagonal.data(), values_.data(),
                inverse_.data(), rows, r_.front().v, z_.front().v);
  for (std::size_t i = 0; i < z_.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) z[i].v[c] = size * static_cast<double>(z_[i].v[c]);
  }
  std::fill(z.begin() + rows, z.end(), NodeValue{});
}

}  // namespace palpate::fem
