// How far the points that the eyes tell lie from where a simulated site knows them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace palpate {

class ErrorOfPoints {
 public:
  // `error`: told minus true, of one point in one pair [m].
  void Add(const Eigen::Vector3d& error) {
    ++count_;
    squares_ += error.squaredNorm();
    peak_ = std::max(peak_, error.norm());
  }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double rms() const {  // [m]
    return count_ > 0 ? std::sqrt(squares_ / static_cast<double>(count_)) : 0;
  }
  [[nodiscard]] double peak() const { return peak_; }  // [m]

 private:
  std::uint64_t count_ = 0;
  double squares_ = 0, peak_ = 0;
};

}  // namespace palpate
