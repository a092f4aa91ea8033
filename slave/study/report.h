// A study as files and as a table. SI units; times are the only numbers that differ between runs.
#pragma once

#include <filesystem>
#include <string>

#include "slave/study/study.h"

namespace palpate::study {

// Returns one line per row, in the order of the study, after the header
//   family,kind,resolution,dof,residual,outcome,error,error_bar,error_small,error_small_bar,
//   deviation,plane_error,validity,update_median_s,update_p99_s,precompute_s,memory_bytes,
//   expected_s,own,on_front,meets_tolerance,meets_rate,recommended,reason
// error: relative error of the contact force at full depth, the worst press, never below error_bar
// (uncertainty of the reference); deviation: difference from the reference; _small: at the small
// depth, where every model is linear. A number that is not known is an empty cell; flags are 0 or
// 1; text with a comma is quoted.
std::string ToCsv(const StudyResult& study);

// All data: the contacts (with their unit), the settings, the references and their origin, the rows
// with every force. Unknown numbers are null.
std::string ToJson(const StudyResult& study);

// Returns a table for people: the rows that answered, fastest first, then what failed or was
// skipped and why.
std::string ToTable(const StudyResult& study);

// Writes study.csv and study.json, each whole or not at all. Throws std::runtime_error
// naming the file.
void WriteStudy(const StudyResult& study, const std::filesystem::path& folder);

}  // namespace palpate::study
