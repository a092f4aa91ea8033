#include "slave/mechanics/linear/grouped_matrix.h"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

using Three = std::array<Float16, 3>;

struct Kept {
  const int *begin, *column;
  const Three *values, *inverse;
  int groups;
};

template <int i>
PALPATE_INLINE Float16 Component(const Float16& x) {
  return __builtin_shufflevector(x, x, i, i, i, i, 4 + i, 4 + i, 4 + i, 4 + i, 8 + i, 8 + i, 8 + i,
                                 8 + i, 12 + i, 12 + i, 12 + i, 12 + i);
}

// Returns the products of blocks, given by columns, with x.
PALPATE_INLINE Float16 Times(const Three& column, const Float16& x) {
  return column[0] * Component<0>(x) + column[1] * Component<1>(x) + column[2] * Component<2>(x);
}

PALPATE_INLINE Float16 Gather(const float* x, const int* position) {
  const Float4 x0 = LoadSingles(x + 4 * static_cast<std::ptrdiff_t>(position[0]));
  const Float4 x1 = LoadSingles(x + 4 * static_cast<std::ptrdiff_t>(position[1]));
  const Float4 x2 = LoadSingles(x + 4 * static_cast<std::ptrdiff_t>(position[2]));
  const Float4 x3 = LoadSingles(x + 4 * static_cast<std::ptrdiff_t>(position[3]));
  const auto low = __builtin_shufflevector(x0, x1, 0, 1, 2, 3, 4, 5, 6, 7);
  const auto high = __builtin_shufflevector(x2, x3, 0, 1, 2, 3, 4, 5, 6, 7);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}

// Adds the products of a group's transposed blocks with x to y, at the blocks' columns.
PALPATE_INLINE void AddTransposed(const Kept& A, int group, const Float16& x, float* y) {
  const Float16 x0 = Component<0>(x), x1 = Component<1>(x), x2 = Component<2>(x);
  for (int k = A.begin[group]; k < A.begin[group + 1]; ++k) {
    const Three& rows = A.values[k];
    const Float16 sum = rows[0] * x0 + rows[1] * x1 + rows[2] * x2;
    const int* position = A.column + 4 * static_cast<std::ptrdiff_t>(k);
    float* y0 = y + 4 * static_cast<std::ptrdiff_t>(position[0]);
    StoreSingles(y0, LoadSingles(y0) + __builtin_shufflevector(sum, sum, 0, 1, 2, 3));
    float* y1 = y + 4 * static_cast<std::ptrdiff_t>(position[1]);
    StoreSingles(y1, LoadSingles(y1) + __builtin_shufflevector(sum, sum, 4, 5, 6, 7));
    float* y2 = y + 4 * static_cast<std::ptrdiff_t>(position[2]);
    StoreSingles(y2, LoadSingles(y2) + __builtin_shufflevector(sum, sum, 8, 9, 10, 11));
    float* y3 = y + 4 * static_cast<std::ptrdiff_t>(position[3]);
    StoreSingles(y3, LoadSingles(y3) + __builtin_shufflevector(sum, sum, 12, 13, 14, 15));
  }
}

// Returns the sums of the products of a group's blocks with x at the blocks' columns.
PALPATE_INLINE Float16 Product(const Kept& A, int group, const float* x) {
  Float16 s0{}, s1{}, s2{};
  for (int k = A.begin[group]; k < A.begin[group + 1]; ++k) {
    const Float16 of = Gather(x, A.column + 4 * static_cast<std::ptrdiff_t>(k));
    s0 += A.values[k][0] * of;
    s1 += A.values[k][1] * of;
    s2 += A.values[k][2] * of;
  }
  // Sums of four numbers each, one after the other.
  const Float16 low =
      __builtin_shufflevector(s0, s1, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
  const Float16 high =
      __builtin_shufflevector(s0, s1, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
  const Float16 both = low + high;
  const Float16 third =
      s2 + __builtin_shufflevector(s2, s2, 2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13);
  return __builtin_shufflevector(both, third, 0, 1, 16, 16, 4, 5, 20, 20, 8, 9, 24, 24, 12, 13, 28,
                                 28) +
         __builtin_shufflevector(both, third, 2, 3, 17, 17, 6, 7, 21, 21, 10, 11, 25, 25, 14, 15,
                                 29, 29);
}

float* Numbers(GroupedMatrix::Vector* x) {
  return reinterpret_cast<float*>(x->data());
}

PALPATE_DISPATCHED void ForwardGroups(Kept A, const Float16* free, float* r, float* z,
                                      Float16* left) {
  for (int g = 0; g < A.groups; ++g) {
    const Float16 of = *reinterpret_cast<const Float16*>(r + 16 * static_cast<std::ptrdiff_t>(g));
    const Float16 zg = Times(A.inverse[g], of);
    *reinterpret_cast<Float16*>(z + 16 * static_cast<std::ptrdiff_t>(g)) = zg;
    AddTransposed(A, g, -zg, r);
  }
  for (int g = A.groups - 1; g >= 0; --g) left[g] = -free[g] * Product(A, g, z);
}

PALPATE_DISPATCHED void Lower(Kept A, const Float16* x, float* y) {
  for (int g = 0; g < A.groups; ++g) AddTransposed(A, g, -x[g], y);
}

PALPATE_DISPATCHED void BackwardGroups(Kept A, const Float16* r, float* z, float* y) {
  for (int g = A.groups - 1; g >= 0; --g) {
    auto* at = reinterpret_cast<Float16*>(z + 16 * static_cast<std::ptrdiff_t>(g));
    const Float16 before = *at;
    const Float16 zg = Times(A.inverse[g], r[g] - Product(A, g, z));
    *at = zg;
    AddTransposed(A, g, zg - before, y);
  }
}

// Copies blocks, scaled, by their rows.
PALPATE_DISPATCHED void Copy(const double* from, double scale, const int* block, std::size_t count,
                             Three* values) {
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const int of = block[4 * k + lane];
      if (of < 0) continue;
      const double* b = from + 9 * static_cast<std::ptrdiff_t>(of);
      const Double4 c0 = scale * Load4(b), c1 = scale * Load4(b + 3), c2 = scale * Load4(b + 6);
      auto* to = reinterpret_cast<float*>(values + k) + 4 * lane;
      for (int r = 0; r < 3; ++r) {
        StoreSingles(to + 16 * r, __builtin_convertvector(Double4{c0[r], c1[r], c2[r], 0}, Float4));
      }
    }
  }
}

}  // namespace

GroupedMatrix::GroupedMatrix(const BlockPattern& pattern)
    : pattern_(pattern), position_(Index(pattern.rows())) {
  Sort();
  guides_.reserve(position_.size());
}

void GroupedMatrix::Sort() {
  const auto rows = position_.size();
  std::vector<int> colour(rows, -1), later(rows, 0), order(rows);
  std::vector<int> used;  // per colour: the last row that has a neighbour of it
  for (int i = 0; i < pattern_.rows(); ++i) {
    for (const int j : pattern_.graph.of(i)) {
      if (colour[Index(j)] >= 0) used[Index(colour[Index(j)])] = i;
    }
    const auto first = std::ranges::find_if(used, [i](int by) { return by != i; });
    colour[Index(i)] = static_cast<int>(first - used.begin());
    if (first == used.end()) used.push_back(-1);
  }
  for (int i = 0; i < pattern_.rows(); ++i) {
    for (const int j : pattern_.graph.of(i)) later[Index(i)] += colour[Index(j)] > colour[Index(i)];
  }
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int i, int j) {
    return colour[Index(i)] != colour[Index(j)] ? colour[Index(i)] < colour[Index(j)]
                                                : later[Index(i)] > later[Index(j)];
  });
  std::vector<std::array<int, 4>> groups;
  int filled = 4;
  for (std::size_t k = 0; k < rows; ++k) {
    const int row = order[k];
    if (filled == 4 || (k > 0 && colour[Index(order[k - 1])] != colour[Index(row)])) {
      groups.push_back({-1, -1, -1, -1});
      filled = 0;
    }
    position_[Index(row)] = 4 * static_cast<int>(groups.size() - 1) + filled;
    groups.back()[Index(filled++)] = row;
  }
  const int nowhere = 4 * static_cast<int>(groups.size());
  begin_.push_back(0);
  for (const auto& group : groups) {
    int steps = 0;
    for (const int row : group) steps = std::max(steps, row < 0 ? 0 : later[Index(row)]);
    const auto first = column_.size();
    column_.resize(first + 4 * Index(steps), nowhere);
    block_.resize(column_.size(), -1);
    for (std::size_t lane = 0; lane < 4; ++lane) {
      if (group[lane] < 0) continue;
      const int row = group[lane];
      auto at = first + lane;
      for (int k = pattern_.graph.begin[Index(row)]; k < pattern_.graph.begin[Index(row) + 1];
           ++k) {
        const int column = pattern_.graph.column[Index(k)];
        if (colour[Index(column)] <= colour[Index(row)]) continue;
        column_[at] = position_[Index(column)];
        block_[at] = k;
        at += 4;
      }
    }
    begin_.push_back(static_cast<int>(column_.size() / 4));
  }
  values_.resize(column_.size() / 4);
  inverse_.resize(groups.size());
  free_.resize(groups.size() + 1);
}

bool GroupedMatrix::Set(const BlockMatrix& A, double scale, const NodeVector& free,
                        std::span<const Guide> guides) noexcept {
  Copy(A.block(0), scale, block_.data(), values_.size(), values_.data());
  float* kept = Numbers(&free_);
  for (int i = 0; i < pattern_.rows(); ++i) {
    const double* f = At(free, i).v;
    for (std::size_t c = 0; c < 3; ++c) kept[Place(i) + c] = static_cast<float>(f[c]);
    const double* of = A.block(pattern_.diagonal[Index(i)]);
    Eigen::Matrix3d block, held = Eigen::Matrix3d::Zero();
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) block(r, c) = scale * f[r] * f[c] * of[3 * c + r];
      held(c, c) = 1 - f[c];
    }
    if (!Invert(i, block, held)) return false;
  }
  guides_.assign(guides.begin(), guides.end());
  return std::ranges::all_of(guides, [&](const Guide& guide) {
    const Eigen::Matrix3d held = guide.normal * guide.normal.transpose();
    const Eigen::Matrix3d among = Eigen::Matrix3d::Identity() - held;
    const Eigen::Map<const Eigen::Matrix3d> of(A.block(pattern_.diagonal[Index(guide.row)]));
    return Invert(guide.row, scale * among * of * among, held);
  });
}

// Keeps the inverse of a block of the diagonal among what `held`, a projection, leaves.
bool GroupedMatrix::Invert(int row, const Eigen::Matrix3d& block,
                           const Eigen::Matrix3d& held) noexcept {
  const Eigen::Vector3d a = block.col(0) + held.col(0), b = block.col(1) + held.col(1),
                        c = block.col(2) + held.col(2);
  const Eigen::Vector3d bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
  const double determinant = a.dot(bc);
  if (!(a[0] > 0) || !(ab[2] > 0) || !(determinant > 0)) return false;
  const std::size_t place = Place(row);
  float* kept = reinterpret_cast<float*>(&inverse_[place / 16]) + place % 16;
  for (int k = 0; k < 3; ++k) {
    kept[16 * k] = static_cast<float>(bc[k] / determinant - held(0, k));
    kept[16 * k + 1] = static_cast<float>(ca[k] / determinant - held(1, k));
    kept[16 * k + 2] = static_cast<float>(ab[k] / determinant - held(2, k));
  }
  return true;
}

void GroupedMatrix::Restrict(Vector* x) const noexcept {
  for (std::size_t g = 0; g < free_.size(); ++g) (*x)[g] *= free_[g];
  for (const Guide& guide : guides_) {
    Eigen::Map<Eigen::Vector3f> of(Numbers(x) + Place(guide.row));
    const Eigen::Vector3f normal = guide.normal.cast<float>();
    of -= normal.dot(of) * normal;
  }
}

void GroupedMatrix::SweepForward(Vector* r, Vector* z, Vector* left) const noexcept {
  ForwardGroups({begin_.data(), column_.data(), values_.data(), inverse_.data(),
                 static_cast<int>(inverse_.size())},
                free_.data(), Numbers(r), Numbers(z), left->data());
}

void GroupedMatrix::SubtractLower(const Vector& x, Vector* y) const noexcept {
  Lower({begin_.data(), column_.data(), values_.data(), inverse_.data(),
         static_cast<int>(inverse_.size())},
        x.data(), Numbers(y));
}

void GroupedMatrix::SweepBackward(const Vector& r, Vector* z, Vector* y) const noexcept {
  BackwardGroups({begin_.data(), column_.data(), values_.data(), inverse_.data(),
                  static_cast<int>(inverse_.size())},
                 r.data(), Numbers(z), Numbers(y));
}

std::size_t GroupedMatrix::memory_bytes() const {
  return sizeof(int) * (column_.size() + block_.size()) +
         sizeof(Three) * (values_.size() + inverse_.size()) + sizeof(Group) * free_.size();
}

}  // namespace palpate::fem
