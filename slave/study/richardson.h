// Extrapolates results on finer and finer meshes to their limit, with an error bar.
#pragma once

#include <vector>

#include "slave/study/study_row.h"

namespace palpate::study {

struct MeshAnswer {
  double size = 0;   // of the elements, any unit, > 0
  double value = 0;  // computed there
};

struct Extrapolation {
  Estimate limit;           // NaN: fewer than two results
  double order = kUnknown;  // observed; NaN: the results do not converge smoothly
};

// f(h) = L + C h^p through the finest result and two coarser ones, each about twice as coarse as
// the one before (Roache 1998, generalised to unequal ratios: p solves (f1 - f2) / (f2 - f3) =
// (h1^p - h2^p) / (h2^p - h3^p)). The error bar is the change of L without the finest result, at
// least a tenth of the step to the limit and at most all of it; with three sizes only, a third of
// that step. If no p between 0.3 and 6 fits, L is the finest result and the bar the spread of the
// three. With two sizes only, L is the finest result and the bar the change. Results may come in
// any order; of equal sizes the last one is used.
Extrapolation Extrapolate(std::vector<MeshAnswer> answers);

}  // namespace palpate::study
