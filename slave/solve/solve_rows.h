// The rows of a contacts or loads file as contacts on an object, and back.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"

namespace palpate {

struct SolveRow {
  std::string case_name;  // rows of one case act together
  Contact contact;
  std::optional<double> t;  // [s], histories only
  ContactResponse response;
  double solve_us = 0;
  // The tool of a prescribed displacement: the scene's tool with the dimensions of the row. A load
  // is uniform over its width, for any tool.
  Tool tool{};
  double off_surface = 0;  // distance of the place in the table from the surface [m]
  // Answer in the table: force of a contact [N], displacement of a load [m]. NaN: none.
  Eigen::Vector3d known_O{0, 0, 0};
};

// Returns whether the row has a round tool.
inline bool IsPressedRound(const SolveRow& row) {
  return row.contact.kind == Contact::Kind::kDisplacement && row.tool.shape == Tool::Shape::kRound;
}

// Rules for reading the rows of a file.
struct RowRules {
  Tool tool;  // of the scene; a flat one without width: it has none
  // The model computes the contact region of that tool itself. Rows then have no other tool.
  bool shaped = false;
  bool dynamic = false;          // a column `t` is read
  bool needs_answers = false;    // the forces of contacts must be there
  bool has_free_points = false;  // a row may have no load: a measured point without load
};
// Rows under the scene's tool, of a table that `solve` reads. Throws std::invalid_argument: no kind
// of model.
RowRules RulesOf(const Scene& scene);

// A row as it was given; an absent dimension is that of the scene's tool.
struct RowValues {
  Eigen::Vector3d p_O{0, 0, 0};                      // place at rest [m]
  Eigen::Vector3d prescribed_O{0, 0, 0};             // displacement [m] or force [N]
  std::optional<double> width{}, radius{}, depth{};  // [m]
};
// Throws an error: the value of `column` is not accepted.
using RefuseColumn = std::function<void(std::string_view column, const std::string& accepted)>;

// Contacts and loads on an object from values.
class RowReader {
 public:
  // Stores references to its arguments. O(N log N) for a volume.
  RowReader(const ObjectMesh& mesh, const RowRules& rules);
  // Calls `refuse` for a position without a surface, a negative width, a value along an axis that
  // the object does not have, a dimension that the row's tool does not have. O(N).
  [[nodiscard]] SolveRow Read(const RowValues& values, Contact::Kind kind,
                              const RefuseColumn& refuse) const;

 private:
  const ObjectMesh& mesh_;
  const RowRules& rules_;
  TouchableSurface surface_;
  double largest_;  // see SizeOf [m]
};

// Appends the rows of `file`, which may be one that WriteRows wrote. Throws
// InputError: what CsvTable or RowReader rejects, and a negative time.
void AppendRows(const std::filesystem::path& file, Contact::Kind kind, const ObjectMesh& mesh,
                const RowRules& rules, std::vector<SolveRow>* rows);

// Throws InputError: a round tool shares its case with other rows.
void RequireAlone(const std::vector<SolveRow>& rows);

// The reason of a row that is extrapolated, one clause.
inline std::string_view ReasonOf(const SolveRow& row) {
  return row.response.flag_reason.empty() ? kBeyondRange : row.response.flag_reason;
}
// The estimated error of the force [N], of a load's displacement [m]; 0: not estimated.
inline double ErrorOf(const ContactResponse& response) {
  return std::max(response.force_error, response.displacement_error);  // one of both is zero
}

// Returns a remark on rows; empty: no remark.
//
// The remark is on rows that touch an outline or a volume at a point.
std::string WidthRemark(const Scene& scene, const std::vector<SolveRow>& rows);
// Returns a remark on rows that are farther from the surface than a hundredth of the object's size:
// they act at its nearest point.
std::string PlaceRemark(const ObjectMesh& mesh, const std::vector<SolveRow>& rows);
// Returns how many rows are extrapolated and why: one sentence per reason, with the first such row.
std::vector<std::string> FlagRemarks(const std::vector<SolveRow>& rows);

// Load history of one position.
class PlaceHistory {
 public:
  // The first row of a position; it defines width and kind.
  explicit PlaceHistory(const SolveRow& first);

  // The row acts at this position, with this kind.
  [[nodiscard]] bool Takes(const SolveRow& row) const;
  void Add(const SolveRow& row);

  // Returns the contact at time `t`: linear between rows, constant before the first and after the
  // last row. Without times it is constant.
  [[nodiscard]] Contact At(double t) const;
  [[nodiscard]] double end() const { return values_.rbegin()->first; }  // [s]

 private:
  Contact contact_;
  std::vector<std::pair<double, Eigen::Vector3d>>
      values_;  // sorted by time, then in the order of the file
};

// The rows `of_case` of `rows`, grouped by position, in the order of their first rows.
std::vector<PlaceHistory> HistoriesOf(const std::vector<SolveRow>& rows,
                                      std::span<const std::size_t> of_case);

}  // namespace palpate
