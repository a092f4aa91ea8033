// The few routines of BLAS and LAPACK that the kernels here share, in single and double precision.
// Names and arguments as there (Anderson et al., LAPACK Users' Guide (1999)): column-major, `ld`
// the stride between columns. They allocate nothing of ours; several threads may call them, each
// call runs on its own (uses_one_thread).
#pragma once

#include <cstddef>
#include <type_traits>

// Fortran's interface: everything by address, the lengths of texts come last.
#define PALPATE_DECLARE(letter, Scalar)                                                            \
  void letter##gemm_(const char*, const char*, const int*, const int*, const int*, const Scalar*,  \
                     const Scalar*, const int*, const Scalar*, const int*, const Scalar*, Scalar*, \
                     const int*, std::size_t, std::size_t);                                        \
  void letter##gemv_(const char*, const int*, const int*, const Scalar*, const Scalar*,            \
                     const int*, const Scalar*, const int*, const Scalar*, Scalar*, const int*,    \
                     std::size_t);                                                                 \
  void letter##potrf_(const char*, const int*, Scalar*, const int*, int*, std::size_t);            \
  void letter##potri_(const char*, const int*, Scalar*, const int*, int*, std::size_t);            \
  void letter##syrk_(const char*, const char*, const int*, const int*, const Scalar*,              \
                     const Scalar*, const int*, const Scalar*, Scalar*, const int*, std::size_t,   \
                     std::size_t);                                                                 \
  void letter##trsm_(const char*, const char*, const char*, const char*, const int*, const int*,   \
                     const Scalar*, const Scalar*, const int*, Scalar*, const int*, std::size_t,   \
                     std::size_t, std::size_t, std::size_t);
extern "C" {
PALPATE_DECLARE(s, float)
PALPATE_DECLARE(d, double)
}
#undef PALPATE_DECLARE

namespace palpate::blas {

// Set in every program that computes: true after the library was configured, before main.
extern const bool uses_one_thread;

template <typename Scalar, typename Single, typename Double>
constexpr auto Pick(Single* in_single, Double* in_double) {
  if constexpr (std::is_same_v<Scalar, float>) {
    return in_single;
  } else {
    return in_double;
  }
}

// C := alpha op(A) op(B) + beta C, C m x n, the inner dimension k; 'N': as it is, 'T': transposed.
template <typename Scalar>
void Gemm(char a_form, char b_form, int m, int n, int k, Scalar alpha, const Scalar* a, int lda,
          const Scalar* b, int ldb, Scalar beta, Scalar* c, int ldc) {
  Pick<Scalar>(sgemm_, dgemm_)(&a_form, &b_form, &m, &n, &k, &alpha, a, &lda, b, &ldb, &beta, c,
                               &ldc, 1, 1);
}

// y := alpha op(A) x + beta y, A m x n.
template <typename Scalar>
void Gemv(char form, int m, int n, Scalar alpha, const Scalar* a, int lda, const Scalar* x,
          Scalar beta, Scalar* y) {
  const int step = 1;
  Pick<Scalar>(sgemv_, dgemv_)(&form, &m, &n, &alpha, a, &lda, x, &step, &beta, y, &step, 1);
}

// The lower triangle of A becomes its Cholesky factor. False: a pivot is not positive; a NaN may
// pass.
template <typename Scalar>
bool Potrf(int n, Scalar* a, int lda) {
  int info = 0;
  Pick<Scalar>(spotrf_, dpotrf_)("L", &n, a, &lda, &info, 1);
  return info == 0;
}

// The lower triangle of A, a Cholesky factor L, becomes that of (L L^T)^-1.
template <typename Scalar>
void Potri(int n, Scalar* a, int lda) {
  int info = 0;
  Pick<Scalar>(spotri_, dpotri_)("L", &n, a, &lda, &info, 1);
}

// The lower triangle of C := C - A A^T, A n x k.
template <typename Scalar>
void SubtractSyrk(int n, int k, const Scalar* a, int lda, Scalar* c, int ldc) {
  const Scalar alpha = -1, beta = 1;
  Pick<Scalar>(ssyrk_, dsyrk_)("L", "N", &n, &k, &alpha, a, &lda, &beta, c, &ldc, 1, 1);
}

// B := op(L)^-1 B ('L') or B op(L)^-1 ('R'), B m x n, L a lower triangle with ones ('U') or what is
// there ('N') on its diagonal.
template <typename Scalar>
void Trsm(char side, char form, char diagonal, int m, int n, const Scalar* l, int ldl, Scalar* b,
          int ldb) {
  if (m <= 0 || n <= 0) return;  // BLAS would complain of a leading dimension of none
  const Scalar one = 1;
  Pick<Scalar>(strsm_, dtrsm_)(&side, "L", &form, &diagonal, &m, &n, &one, l, &ldl, b, &ldb, 1, 1,
                               1, 1);
}

}  // namespace palpate::blas
