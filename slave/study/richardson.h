// The limit of a sequence of answers on finer and finer meshes, and how far to trust it.
#pragma once

#include <vector>

#include "slave/study/study_row.h"

namespace palpate::study {

struct MeshAnswer {
  double size = 0;   // of the elements, any unit, > 0
  double value = 0;  // computed there
};

struct Extrapolation {
  Estimate limit;           // NaN: fewer than two answers
  double order = kUnknown;  // observed; NaN: the answers do not converge smoothly
};

// f(h) = L + C h^p through the finest answer and two coarser ones, each about twice as coarse as
// the one before (Roache 1998, generalised to unequal ratios: p solves
// (f1 - f2) / (f2 - f3) = (h1^p - h2^p) / (h2^p - h3^p)). The error bar is the change of L when the
// finest answer is left out, at least a tenth of the step to the limit and at most all of it; with
// three sizes only, a third of that step. Where no p between 0.3 and 6 fits, L is the finest answer
// and the bar the spread of the three. Of two sizes only, p is `order` where that is known, the bar
// as of three; else L is the finest answer and the bar the change. Answers may come in any order;
// of equal sizes the last one counts.
Extrapolation Extrapolate(std::vector<MeshAnswer> answers, double order = kUnknown);

}  // namespace palpate::study
