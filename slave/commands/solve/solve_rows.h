// The rows of a contacts or loads file as contacts on an object, and back.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"

namespace palpate {

struct SolveRow {
  std::string case_name;  // rows of one case act together
  Contact contact;
  std::optional<double> t;  // [s], histories only
  ContactResponse response;
  double solve_us = 0;
  double radius = 0;  // of a round tool's end [m]; 0: the contact's width
};

// Appends the rows of `file` (contracts, `solve`). A column `t` is read if `dynamic`. Throws
// InputError: what CsvTable refuses, a place that cannot be touched, a negative width or time, a
// value along an axis that the object does not have, a history in time of a body at rest.
void AppendRows(const std::filesystem::path& file, Contact::Kind kind, const ObjectMesh& mesh,
                bool dynamic, std::vector<SolveRow>* rows);

// Says on stderr how many rows are extrapolated and why: a line per reason, with the first such
// row.
void ReportFlags(const std::vector<SolveRow>& rows);

// Writes one line per row with 17 significant digits, with `t` if they have one. False: the file
// cannot be written.
bool WriteRows(const std::filesystem::path& file, const std::vector<SolveRow>& rows);

// What acts on one place of a body over time.
class PlaceHistory {
 public:
  // The first row of a place; its width and kind go with it.
  explicit PlaceHistory(const SolveRow& first);

  // The row acts at this place, in this way.
  [[nodiscard]] bool Takes(const SolveRow& row) const;
  void Add(const SolveRow& row);

  // Linear between rows; the first row's value before it, the last one's after it (contracts,
  // `solve`). Without times: constant.
  [[nodiscard]] Contact At(double t) const;
  [[nodiscard]] double end() const { return values_.rbegin()->first; }  // [s]

 private:
  Contact contact_;
  std::vector<std::pair<double, Eigen::Vector3d>> values_;  // by time, then as the rows came
};

// The rows `of_case` of `rows`, by place, in the order of their first rows.
std::vector<PlaceHistory> HistoriesOf(const std::vector<SolveRow>& rows,
                                      std::span<const std::size_t> of_case);

}  // namespace palpate
