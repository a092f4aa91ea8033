#include "slave/capture/time_column.h"

#include <array>
#include <cmath>

namespace palpate {
namespace {

constexpr std::array kNames{"rel_time_s", "time_s", "t", "time", "timestamp"};
constexpr double kLatest = 9e9;  // the year 2255; stamps in milliseconds lie far beyond

}  // namespace

std::size_t FindTimeColumn(const CsvRows& rows) {
  for (const char* name : kNames) {
    if (const auto column = rows.Find(name)) return *column;
  }
  rows.Fail("no time: accepted is a column rel_time_s, time_s, t, time or timestamp [s]");
}

double ReadTime(const CsvRows& rows, std::size_t column, const double* before) {
  const auto t = ParseFinite(rows.Text(column));
  if (!t || std::abs(*t) > kLatest) rows.Refuse(column, "a time in seconds");
  if (before != nullptr && *t < *before) {
    rows.Refuse(column, "a clock that does not go back, from " + std::to_string(*before) + " on");
  }
  return *t;
}

}  // namespace palpate
