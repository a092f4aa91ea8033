// Which column of a recording is its clock, and what a clock may do.
#pragma once

#include <cstddef>

#include "shared/text/csv.h"

namespace palpate {

// `rel_time_s`, `time_s`, `t`, `time` or `timestamp`, the first that is there. Throws
// std::runtime_error `file:line: ...`: none is.
std::size_t FindTimeColumn(const CsvRows& rows);

// The time of this row [s]. Throws: no time in seconds, or earlier than `*before` (null: the first
// row).
double ReadTime(const CsvRows& rows, std::size_t column, const double* before);

}  // namespace palpate
