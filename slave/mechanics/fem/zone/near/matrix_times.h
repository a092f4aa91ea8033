// Products of dense matrices and vectors in single precision. Nothing is allocated.
#pragma once

#include <span>

#include <Eigen/Core>
#include <cblas.h>

namespace palpate {

// By OpenBLAS: it picks the instructions of the machine.
inline void MatrixTimes(const Eigen::MatrixXf& a, CBLAS_TRANSPOSE form, const Eigen::VectorXf& x,
                        Eigen::VectorXf* y) noexcept {
  if (a.size() == 0) {
    y->setZero();
    return;
  }
  const int rows = static_cast<int>(a.rows()), columns = static_cast<int>(a.cols());
  cblas_sgemv(CblasColMajor, form, rows, columns, 1, a.data(), rows, x.data(), 1, 0, y->data(), 1);
}
// y = A x, y = A^T x.
inline void MatrixTimes(const Eigen::MatrixXf& a, const Eigen::VectorXf& x,
                        Eigen::VectorXf* y) noexcept {
  MatrixTimes(a, CblasNoTrans, x, y);
}
inline void TransposedTimes(const Eigen::MatrixXf& a, const Eigen::VectorXf& x,
                            Eigen::VectorXf* y) noexcept {
  MatrixTimes(a, CblasTrans, x, y);
}

// y += A x where x is zero but for three numbers from 3 n on, for every n of `places`.
void AddPlaces(const Eigen::MatrixXf& a, std::span<const int> places, const Eigen::VectorXf& x,
               Eigen::VectorXf* y) noexcept;

}  // namespace palpate
