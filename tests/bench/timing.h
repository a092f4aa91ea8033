// CPU times of the calling thread and reference times to compare them with.
#pragma once

#include <algorithm>
#include <ctime>
#include <limits>
#include <vector>

#include <Eigen/LU>
#include <benchmark/benchmark.h>

namespace palpate {

// CPU time of this thread [s]. The time of other programs does not count.
inline double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// The shortest of several batches of `times` calls [s per call].
template <typename Call>
double Shortest(const Call& call, int times) {
  double shortest = std::numeric_limits<double>::infinity();
  for (int batch = 0; batch < 7; ++batch) {
    const double start = CpuSeconds();
    for (int k = 0; k < times; ++k) call();
    shortest = std::min(shortest, (CpuSeconds() - start) / times);
  }
  return shortest;
}

// A dense solution with `order` unknowns and `columns` right-hand sides by Eigen's LU [s].
inline double EigenLuSeconds(int order, int columns) {
  const Eigen::MatrixXd A =
      Eigen::MatrixXd::Random(order, order) + order * Eigen::MatrixXd::Identity(order, order);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(order, columns);
  const auto solve = [&] {
    Eigen::MatrixXd x = A.partialPivLu().solve(b);
    benchmark::DoNotOptimize(x.data());
  };
  return Shortest(solve, 20000 / order + 10);
}

// A dense product of 768 x 768 matrices [s].
inline double ProductSeconds() {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(768, 768);
  Eigen::MatrixXd c = a * a;
  const auto multiply = [&] {
    c.noalias() = a * a;
    benchmark::DoNotOptimize(c.data());
  };
  return Shortest(multiply, 1);
}

// `share` of the values are at most this large; zero without values.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace palpate
