// Symmetric band matrices, factorised without pivoting.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace palpate::plate {

// Largest absolute entry; NaN where there is one. Unlike a sum of squares it does not lose what is
// smaller than 1e-154.
template <typename Vector>
double LargestEntry(const Eigen::MatrixBase<Vector>& v) {
  return v.size() == 0 ? 0 : v.cwiseAbs().template maxCoeff<Eigen::PropagateNaN>();
}

// A = L D L^T for symmetric quasi-definite A (Vanderbei 1995: then no pivoting is needed).
class BandedSymmetric {
 public:
  // Entries (i, j) with |i - j| <= band.
  BandedSymmetric(int size, int band);

  void SetZero();
  // Of the lower half: i - band <= j <= i.
  [[nodiscard]] double& at(int i, int j) { return rows_[Place(i, j)]; }
  // Row and column `i` become those of the identity.
  void Hold(int i);
  // In place. False: a pivot vanishes or is not finite. O(size band^2), no allocation.
  bool Factorise() noexcept;
  // Overwrites the right-hand side. O(size band).
  void Solve(Eigen::Ref<Eigen::VectorXd> x) const noexcept;

 private:
  [[nodiscard]] std::size_t Place(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(band_ + 1) +
           static_cast<std::size_t>(j - i + band_);
  }

  int size_, band_;
  std::vector<double> rows_;  // row by row, the diagonal last
};

}  // namespace palpate::plate
