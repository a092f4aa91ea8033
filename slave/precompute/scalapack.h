// Declarations of the calls of ScaLAPACK and BLACS that are used: Debian has no header of them.
#pragma once

extern "C" {
void Cblacs_get(int context, int what, int* value);
void Cblacs_gridinit(int* context, const char* order, int rows, int columns);
void Cblacs_gridinfo(int context, int* rows, int* columns, int* row, int* column);
void Cblacs_gridexit(int context);
void Cpdgemr2d(int rows, int columns, const double* a, int ia, int ja, const int* desc_a, double* b,
               int ib, int jb, const int* desc_b, int context);

int numroc_(const int* count, const int* block, const int* process, const int* first,
            const int* processes);
double pdlange_(const char* norm, const int* m, const int* n, const double* a, const int* ia,
                const int* ja, const int* desc_a, double* work);
void pdgetrf_(const int* m, const int* n, double* a, const int* ia, const int* ja,
              const int* desc_a, int* pivots, int* info);
void pdgetrs_(const char* transposed, const int* n, const int* columns, const double* a,
              const int* ia, const int* ja, const int* desc_a, const int* pivots, double* b,
              const int* ib, const int* jb, const int* desc_b, int* info);
void pdgecon_(const char* norm, const int* n, const double* a, const int* ia, const int* ja,
              const int* desc_a, const double* norm_of_a, double* reciprocal, double* work,
              const int* work_size, int* int_work, const int* int_work_size, int* info);
void pdlapiv_(const char* direction, const char* what, const char* pivots_are, const int* m,
              const int* n, double* a, const int* ia, const int* ja, const int* desc_a,
              const int* pivots, const int* ip, const int* jp, const int* desc_pivots, int* work);
void pdtrsm_(const char* side, const char* triangle, const char* transposed, const char* diagonal,
             const int* m, const int* n, const double* alpha, const double* a, const int* ia,
             const int* ja, const int* desc_a, double* b, const int* ib, const int* jb,
             const int* desc_b);
void pdgemm_(const char* transposed_a, const char* transposed_b, const int* m, const int* n,
             const int* k, const double* alpha, const double* a, const int* ia, const int* ja,
             const int* desc_a, const double* b, const int* ib, const int* jb, const int* desc_b,
             const double* beta, double* c, const int* ic, const int* jc, const int* desc_c);
}
