#include "slave/mechanics/linear/two_grid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <lapacke.h>

#include "slave/mechanics/linear/lanes.h"
#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

using Eigen::Vector3d;

constexpr int kNodesPerVertex = 27;  // of the fine grid to the coarse one: three along each axis
constexpr int kMaxVertices = 2000;   // whose band fits in the cache
constexpr double kFiner = 1.05;      // from one grid that is tried to the next
constexpr double kMinShift = 1e-6;   // of the coarse diagonal: what rounding may take from it
constexpr double kMaxShift = 1e-4;

struct Cubes {
  const int* begin;                    // per cube: its first node
  const std::array<int, 8>* vertices;  // per cube
  const CubeNode* nodes;
  const GridPlace* places;  // per row
  int count;
};

// coarse = P^T x
PALPATE_DISPATCHED void Restrict(const Cubes& cubes, const float* x, float* coarse) {
  for (int cube = 0; cube < cubes.count; ++cube) {
    Float16 low{}, high{};
    for (int n = cubes.begin[cube]; n < cubes.begin[cube + 1]; ++n) {
      const CubeNode& node = cubes.nodes[n];
      const Float8 w = *reinterpret_cast<const LooseFloat8*>(cubes.places[node.row].weight.data());
      const Float4 of = LoadSingles(x + node.place);
      const Float16 all =
          __builtin_shufflevector(of, of, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
      low += all * __builtin_shufflevector(w, w, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
      high += all * __builtin_shufflevector(w, w, 4, 4, 4, 4, 5, 5, 5, 5, 6, 6, 6, 6, 7, 7, 7, 7);
    }
    float sums[32];
    *reinterpret_cast<LooseFloat16*>(sums) = low;
    *reinterpret_cast<LooseFloat16*>(sums + 16) = high;
    for (int b = 0; b < 8; ++b) {
      float* to = coarse + 3 * static_cast<std::ptrdiff_t>(
                                   cubes.vertices[cube][static_cast<std::size_t>(b)]);
      for (int c = 0; c < 3; ++c) to[c] += sums[4 * b + c];
    }
  }
}

// x = P coarse
PALPATE_DISPATCHED void Prolongate(const Cubes& cubes, const float* coarse, float* x) {
  for (int cube = 0; cube < cubes.count; ++cube) {
    Float4 at[8];
    for (int b = 0; b < 8; ++b) {
      at[b] = LoadSingles(coarse + 3 * static_cast<std::ptrdiff_t>(
                                           cubes.vertices[cube][static_cast<std::size_t>(b)]));
    }
    for (int n = cubes.begin[cube]; n < cubes.begin[cube + 1]; ++n) {
      const CubeNode& node = cubes.nodes[n];
      const float* t = node.t;
      const Float4 y0 = at[0] + t[0] * (at[1] - at[0]), y1 = at[2] + t[0] * (at[3] - at[2]);
      const Float4 y2 = at[4] + t[0] * (at[5] - at[4]), y3 = at[6] + t[0] * (at[7] - at[6]);
      const Float4 z0 = y0 + t[1] * (y1 - y0), z1 = y2 + t[1] * (y3 - y2);
      StoreSingles(x + node.place, z0 + t[2] * (z1 - z0));
    }
  }
}

// Solves L L^T x = x. Columns of L below the diagonal, each `width` long, after the inverse of the
// diagonal; x has room for `width` more numbers.
PALPATE_DISPATCHED void SolveBand(const float* inverse, const float* below, int width, int order,
                                  float* x) {
  for (int j = 0; j < order; ++j) {
    const float* column = below + static_cast<std::ptrdiff_t>(j) * width;
    const float xj = x[j] *= inverse[j];
    for (int k = 0; k < width; k += 16) {
      auto* at = reinterpret_cast<LooseFloat16*>(x + j + 1 + k);
      *at -= *reinterpret_cast<const LooseFloat16*>(column + k) * xj;
    }
  }
  for (int j = order - 1; j >= 0; --j) {
    const float* column = below + static_cast<std::ptrdiff_t>(j) * width;
    Float16 even{}, odd{};
    for (int k = 0; k < width; k += 32) {
      even += *reinterpret_cast<const LooseFloat16*>(column + k) *
              *reinterpret_cast<const LooseFloat16*>(x + j + 1 + k);
      odd += *reinterpret_cast<const LooseFloat16*>(column + k + 16) *
             *reinterpret_cast<const LooseFloat16*>(x + j + 17 + k);
    }
    const Float16 sum = even + odd;
    const Float8 half = __builtin_shufflevector(sum, sum, 0, 1, 2, 3, 4, 5, 6, 7) +
                        __builtin_shufflevector(sum, sum, 8, 9, 10, 11, 12, 13, 14, 15);
    const Float4 four = __builtin_shufflevector(half, half, 0, 1, 2, 3) +
                        __builtin_shufflevector(half, half, 4, 5, 6, 7);
    x[j] = inverse[j] * (x[j] - ((four[0] + four[1]) + (four[2] + four[3])));
  }
}

PALPATE_INLINE double SumOf(const Float16& x) {
  double sum = 0;
  for (int k = 0; k < 16; ++k) sum += static_cast<double>(x[k]);
  return sum;
}

PALPATE_DISPATCHED double HalfDotOf(const Float16* a, const Float16* b, std::size_t count) {
  Float16 even{}, odd{};
  std::size_t g = 0;
  for (; g + 2 <= count; g += 2) even += a[g] * b[g], odd += a[g + 1] * b[g + 1];
  for (; g < count; ++g) even += a[g] * b[g];
  return SumOf(even + odd);
}

// p = z + beta p, q = Az + beta q. Returns p . q.
PALPATE_DISPATCHED double NextDirection(const Float16* z, const Float16* Az, float beta, Float16* p,
                                        Float16* q, std::size_t count) {
  Float16 sum{};
  for (std::size_t g = 0; g < count; ++g) {
    const Float16 next = z[g] + beta * p[g], product = Az[g] + beta * q[g];
    p[g] = next;
    q[g] = product;
    sum += next * product;
  }
  return SumOf(sum);
}

// x += alpha p, r -= alpha q. Returns r . r.
PALPATE_DISPATCHED double Advance(const Float16* p, const Float16* q, float alpha, Float16* x,
                                  Float16* r, std::size_t count) {
  Float16 sum{};
  for (std::size_t g = 0; g < count; ++g) {
    x[g] += alpha * p[g];
    const Float16 left = r[g] - alpha * q[g];
    r[g] = left;
    sum += left * left;
  }
  return SumOf(sum);
}

struct FineMatrix {
  const int *begin, *column;
  const double* values;
  const NodeValue* free;
  const GridPlace* places;
  double scale;
};

struct CoarseCube {
  int *vertex, *slot;  // about one cube; per vertex: its place there, or -1
  Float16* row;        // per place: three columns of a row's sum
  Float16* sums;       // per place and corner of the cube, the same
  char* is_used;       // per place: the row's sum is not zero
};

// Adds the products of a row's blocks with P.
PALPATE_INLINE int AddRow(const FineMatrix& A, int row, int count, const CoarseCube& near) {
  const Double4 free_row = A.scale * Load4(A.free[row].v);
  for (int k = A.begin[row]; k < A.begin[row + 1]; ++k) {
    const double* from = A.values + 9 * static_cast<std::size_t>(k);
    const double* free_column = A.free[A.column[k]].v;
    const GridPlace& there = A.places[A.column[k]];
    Float4 column[3];
    for (int c = 0; c < 3; ++c) {
      column[c] = __builtin_convertvector(free_column[c] * free_row * Load4(from + 3 * c), Float4);
    }
    const Float8 low = __builtin_shufflevector(column[0], column[1], 0, 1, 2, 3, 4, 5, 6, 7);
    const Float8 high = __builtin_shufflevector(column[2], Float4{}, 0, 1, 2, 3, 4, 5, 6, 7);
    const Float16 block =
        __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (std::size_t b = 0; b < 8; ++b) {
      int& slot = near.slot[there.vertex[b]];
      if (slot < 0) {
        slot = count++;
        near.vertex[slot] = there.vertex[b];
        near.row[slot] = Float16{};
        for (std::size_t a = 0; a < 8; ++a) near.sums[8 * slot + a] = Float16{};
      }
      near.is_used[slot] = 1;
      near.row[slot] += there.weight[b] * block;
    }
  }
  return count;
}

// Adds P_i^T A_i P of the rows i of each cube to a lower band by columns, which has room for three
// numbers more.
PALPATE_DISPATCHED void AddCoarse(const FineMatrix& A, const int* begin, const int* rows, int cubes,
                                  const CoarseCube& near, int band, double* coarse) {
  for (int cube = 0; cube < cubes; ++cube) {
    const auto& vertex = A.places[rows[begin[cube]]].vertex;
    int count = 0;
    for (int k = begin[cube]; k < begin[cube + 1]; ++k) {
      count = AddRow(A, rows[k], count, near);
      const GridPlace& here = A.places[rows[k]];
      for (int n = 0; n < count; ++n) {
        if (near.is_used[n] == 0) continue;
        near.is_used[n] = 0;
        const Float16 sum = near.row[n];
        near.row[n] = Float16{};
        for (std::size_t a = 0; a < 8; ++a) near.sums[8 * n + a] += here.weight[a] * sum;
      }
    }
    for (int n = 0; n < count; ++n) {
      const int there = near.vertex[n];
      near.slot[there] = -1;
      for (std::size_t a = 0; a < 8; ++a) {
        if (vertex[a] < there) continue;
        const auto* sum = reinterpret_cast<const float*>(near.sums + 8 * n + a);
        for (int c = 0; c < 3; ++c) {
          double* to = coarse + static_cast<std::ptrdiff_t>(3 * there + c) * band + 3 * vertex[a];
          const Double4 of = __builtin_convertvector(LoadSingles(sum + 4 * c), Double4);
          if (vertex[a] > there) {
            Store4(to, Load4(to) + of);
          } else {
            for (int r = c; r < 3; ++r) to[r] += of[r];
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
      fine_(pattern),
      r_(fine_.MakeVector()),
      z_(r_),
      left_(r_),
      rest_(r_),
      product_(r_),
      x_(r_),
      p_(r_),
      q_(r_) {
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
  width_ = (band_ + 31) / 32 * 32;
  below_.resize(Index(3 * vertices_) * Index(width_));
  inverse_.resize(Index(3 * vertices_));
  coarse_x_.resize(Index(3 * vertices_ + 1 + width_));
  slot_.assign(Index(vertices_), -1);
  near_.resize(Index(vertices_));
  row_sums_.resize(Index(vertices_));
  sums_.resize(Index(8 * vertices_));
  is_used_.resize(Index(vertices_));
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
  std::map<int, std::array<int, 8>> corners;
  std::vector<std::pair<int, CubeNode>> nodes;  // by the first corners of their cubes
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vector3d t;
    const Eigen::Array3i cell = CellAt(place_of(i), cells, &t);
    const Eigen::Vector3f single = t.cast<float>();
    const int row = static_cast<int>(i);
    nodes.push_back({VertexOf(cell, cells, 0),
                     {row, static_cast<int>(fine_.Place(row)), {single[0], single[1], single[2]}}});
    for (int corner = 0; corner < 8; ++corner) {
      const auto found = std::ranges::lower_bound(used, VertexOf(cell, cells, corner));
      places_[i].vertex[Index(corner)] = static_cast<int>(found - used.begin());
      places_[i].weight[Index(corner)] = ((corner & 1) != 0 ? single[0] : 1 - single[0]) *
                                         ((corner & 2) != 0 ? single[1] : 1 - single[1]) *
                                         ((corner & 4) != 0 ? single[2] : 1 - single[2]);
    }
    corners.try_emplace(nodes.back().first, places_[i].vertex);
  }
  std::ranges::stable_sort(nodes, {}, &std::pair<int, CubeNode>::first);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (n == 0 || nodes[n].first != nodes[n - 1].first) {
      cube_begin_.push_back(static_cast<int>(n));
      cube_vertices_.push_back(corners.at(nodes[n].first));
    }
    cube_nodes_.push_back(nodes[n].second);
    cube_rows_.push_back(nodes[n].second.row);
  }
  cube_begin_.push_back(static_cast<int>(nodes.size()));
}

std::size_t TwoGrid::memory_bytes() const {
  return sizeof(double) * coarse_.size() + sizeof(float) * below_.size() +
         places_.size() * sizeof(GridPlace) + fine_.memory_bytes() +
         2 * free_.size() * sizeof(NodeValue) + 8 * r_.size() * sizeof(Float16);
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
  return fine_.Set(A, scale_, free, guides);
}

bool TwoGrid::FactorCoarse(const BlockMatrix& A) noexcept {
  coarse_free_ = free_;
  for (double shift = kMinShift; shift <= kMaxShift; shift *= 1e2) {
    std::ranges::fill(coarse_, 0.0);
    AddCoarse({pattern_.graph.begin.data(), pattern_.graph.column.data(), A.block(0), free_.data(),
               places_.data(), scale_},
              cube_begin_.data(), cube_rows_.data(), static_cast<int>(cube_vertices_.size()),
              {near_.data(), slot_.data(), row_sums_.data(), sums_.data(), is_used_.data()}, band_,
              coarse_.data());
    for (int i = 0; i < 3 * vertices_; ++i) {
      double& diagonal = Coarse(i, i);
      diagonal = diagonal > 0 ? (1 + shift) * diagonal : 1;
    }
    if (LAPACKE_dpbtrf_work(LAPACK_COL_MAJOR, 'L', 3 * vertices_, band_, coarse_.data(),
                            band_ + 1) == 0) {
      KeepCoarse();
      return true;
    }
  }
  return false;
}

// The factor of the coarse grid in single precision.
void TwoGrid::KeepCoarse() noexcept {
  for (int j = 0; j < 3 * vertices_; ++j) {
    inverse_[Index(j)] = static_cast<float>(1 / Coarse(j, j));
    float* column = &below_[Index(j) * Index(width_)];
    const int rows = std::min(band_, 3 * vertices_ - 1 - j);
    for (int k = 0; k < rows; ++k) column[k] = static_cast<float>(Coarse(j + 1 + k, j));
  }
}

// Replaces what is left by the coarse grid's correction.
void TwoGrid::CorrectCoarsely() noexcept {
  fine_.Restrict(&left_);
  std::ranges::fill(coarse_x_, 0.0F);
  const Cubes cubes{cube_begin_.data(), cube_vertices_.data(), cube_nodes_.data(), places_.data(),
                    static_cast<int>(cube_vertices_.size())};
  auto* left = reinterpret_cast<float*>(left_.data());
  palpate::fem::Restrict(cubes, left, coarse_x_.data());
  SolveBand(inverse_.data(), below_.data(), width_, 3 * vertices_, coarse_x_.data());
  Prolongate(cubes, coarse_x_.data(), left);
  fine_.Restrict(&left_);
}

void TwoGrid::Take(const NodeVector& r) noexcept {
  size_ = Norm(r);
  auto* numbers = reinterpret_cast<float*>(r_.data());
  const double factor = size_ > 0 ? 1 / size_ : 0;
  for (int i = 0; i < pattern_.rows(); ++i) {
    StoreSingles(numbers + fine_.Place(i),
                 __builtin_convertvector(factor * Load4(At(r, i).v), Float4));
  }
  fine_.Restrict(&r_);
}

void TwoGrid::AddTo(const GroupedMatrix::Vector& x, double factor, NodeVector& y) const noexcept {
  const auto* numbers = reinterpret_cast<const float*>(x.data());
  for (int i = 0; i < pattern_.rows(); ++i) {
    const Double4 of = __builtin_convertvector(LoadSingles(numbers + fine_.Place(i)), Double4);
    Store4(At(y, i).v, Load4(At(y, i).v) + factor * of);
  }
}

// z_ = M^-1 r_ and product_ = A z_.
void TwoGrid::Cycle() noexcept {
  product_ = rest_ = r_;
  fine_.SweepForward(&rest_, &z_, &left_);
  CorrectCoarsely();
  fine_.SubtractLower(left_, &rest_);
  for (std::size_t g = 0; g < z_.size(); ++g) z_[g] += left_[g];
  fine_.SweepBackward(rest_, &z_, &product_);
}

void TwoGrid::Solve(const NodeVector& r, NodeVector& z) noexcept {
  SetZero(z);
  Take(r);
  if (!(size_ > 0)) return;
  Cycle();
  AddTo(z_, size_ * scale_, z);
}

void TwoGrid::Begin(const NodeVector& r) noexcept {
  Take(r);
  for (auto* of : {&x_, &p_, &q_}) std::ranges::fill(*of, Float16{});
  left_share_ = 1;
  rho_ = 0;
}

double TwoGrid::Iterate() noexcept {
  Cycle();
  fine_.Restrict(&product_);
  const double rho = HalfDotOf(r_.data(), z_.data(), r_.size());
  if (!(rho > 0)) return rho;
  const double curvature =
      NextDirection(z_.data(), product_.data(), rho_ > 0 ? static_cast<float>(rho / rho_) : 0,
                    p_.data(), q_.data(), r_.size());
  rho_ = rho;
  if (!(curvature > 0)) return curvature;
  left_share_ = std::sqrt(Advance(p_.data(), q_.data(), static_cast<float>(rho / curvature),
                                  x_.data(), r_.data(), r_.size()));
  return curvature;
}

void TwoGrid::End(NodeVector& r, NodeVector& x) const noexcept {
  SetZero(r);
  AddTo(r_, size_, r);
  AddTo(x_, size_ * scale_, x);
}

}  // namespace palpate::fem
