// Compares the kernels of slave/mechanics/linear with a library that could replace them, on one
// thread. Counters: `ratio`: our CPU time divided by the library's for the same task, measured in
// the same run (below one: ours is faster). `factor_us`, `solve_us`: our times.
#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <benchmark/benchmark.h>

#include "slave/mechanics/linear/dense_factor.h"
#include "slave/mechanics/linear/dense_lu.h"
#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mechanics/linear/sparse_ldlt.h"
#include "tests/bench/timing.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A compliance: its symmetric part is positive definite.
MatrixXd Compliance(int order) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> side(-1, 1);
  const MatrixXd R = MatrixXd::NullaryExpr(order, order, [&] { return side(random); });
  return R * R.transpose() / order + 0.1 * (R - R.transpose()) + MatrixXd::Identity(order, order);
}

int Times(int order) {
  return std::max(1, 20'000'000 / (order * order * order));
}

void Compare(benchmark::State& state, double ours, double library) {
  for (auto _ : state) {  // the comparison is the measurement
  }
  state.counters["us"] = 1e6 * ours;
  state.counters["ratio"] = ours / library;
}

// Factor and as many solutions as unknowns. Library: Eigen's LU.
void LargeLu(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const MatrixXd A = MatrixXd::Random(n, n), B = MatrixXd::Random(n, n);
  MatrixXd X;
  const double ours = Shortest(
      [&] {
        DenseLu lu(A);
        while (lu.done() < lu.blocks()) lu.FactorizeNext();
        X = B;
        lu.SolveInPlace(X);
      },
      1);
  Compare(state, ours, Shortest([&] { X = A.partialPivLu().solve(B); }, 1));
}
BENCHMARK(LargeLu)->Arg(500)->Arg(1000)->Arg(2000)->Iterations(1);

// Two right-hand sides. Library: LAPACK through DenseLu.
void SmallSystem(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const MatrixXd A = Compliance(n), B = MatrixXd::Random(n, 2);
  RowMatrix right = RowMatrix::Zero(n, kLane8);
  right.leftCols(2) = B;
  RowMatrix x = right;
  DenseFactor factor;
  const double ours = Shortest(
      [&] {
        factor.Reset(n);
        for (int i = 0; i < n; ++i) std::copy_n(A.col(i).data(), n, factor.row(i));
        x = right;
        factor.Factorise();
        factor.Solve({x.data(), kLane8});
        benchmark::DoNotOptimize(x.data());
      },
      Times(n));
  MatrixXd X;
  const double library = Shortest(
      [&] {
        DenseLu lu(A);
        lu.FactorizeNext();
        X = B;
        lu.SolveInPlace(X);
      },
      Times(n));
  Compare(state, ours, library);
}
BENCHMARK(SmallSystem)->ArgsProduct({{2, 6, 16, 32, 64, 128, 192}})->Iterations(1);

// Three unknowns per node of a grid of side^3 nodes, neighbours all around, in the elimination's
// order; negative ones on the diagonal of every 16th.
Eigen::SparseMatrix<double> GridStiffness(int side) {
  std::vector<std::vector<int>> neighbours;
  for (int i = 0; i < side * side * side; ++i) {
    auto& list = neighbours.emplace_back();
    const std::array at{i % side, i / side % side, i / side / side};
    for (int k = 0; k < 27; ++k) {
      const std::array by{at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1};
      if (std::ranges::any_of(by, [&](int c) { return c < 0 || c >= side; })) continue;
      list.push_back(by[0] + side * (by[1] + side * by[2]));
    }
  }
  const auto order = EliminationOrder(neighbours);
  std::vector<int> rank(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    rank[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t node = 0; node < order.size(); ++node) {
    for (const int other : neighbours[node]) {
      for (int k = 0; k < 9; ++k) {
        const int row = 3 * rank[node] + k / 3;
        const int column = 3 * rank[static_cast<std::size_t>(other)] + k % 3;
        if (row > column) continue;
        const double diagonal = row % 16 == 0 ? -100 : 100;
        entries.emplace_back(row, column, row == column ? diagonal : 1.0 / (1 + row % 3 + k));
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(3 * order.size());
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// `ratio`: one factorisation with a known pattern. `solve_ratio`: one solution. `together`: time of
// 24 solutions at once divided by the time of 24 single ones. Library: Eigen's SimplicialLDLT in
// the same order.
template <typename Scalar>
void SparseSymmetric(benchmark::State& state) {
  const auto matrix = GridStiffness(static_cast<int>(state.range(0)));
  SparseLdlt<Scalar> ours(matrix);
  ours.Allocate(matrix);
  const Eigen::SparseMatrix<Scalar> values = matrix.template cast<Scalar>();
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<Scalar>, Eigen::Upper, Eigen::NaturalOrdering<int>>
      library;
  library.analyzePattern(values);
  const int times = matrix.cols() < 3000 ? 20 : 1;
  typename SparseLdlt<Scalar>::Vector x = SparseLdlt<Scalar>::Vector::Ones(matrix.cols()), y = x;
  typename SparseLdlt<Scalar>::Columns X = SparseLdlt<Scalar>::Columns::Ones(matrix.cols(), 24);
  const double factor = Shortest([&] { ours.Factorize(matrix, false); }, times);
  const double solve = Shortest([&] { ours.Solve(&x); }, times);
  Compare(state, factor, Shortest([&] { library.factorize(values); }, times));
  state.counters["solve_us"] = 1e6 * solve;
  state.counters["solve_ratio"] = solve / Shortest([&] { y = library.solve(y); }, times);
  state.counters["together"] = Shortest([&] { ours.Solve(X); }, times) / (24 * solve);
  state.counters["unknowns"] = static_cast<double>(matrix.cols());
}
BENCHMARK(SparseSymmetric<float>)->ArgsProduct({{4, 6, 9, 12, 18, 24}})->Iterations(1);
BENCHMARK(SparseSymmetric<double>)->ArgsProduct({{4, 6, 9, 12, 18, 24}})->Iterations(1);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
