// The rows of a contacts or loads file as contacts on an object, and back.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"

namespace palpate {

struct SolveRow {
  std::string case_name;  // rows of one case act together
  Contact contact;
  std::optional<double> t;  // [s], histories only
  ContactResponse response;
  double solve_us = 0;
};

// Appends the rows of `file` (contracts, `solve`). A column `t` is read if `dynamic`. Throws
// InputError: what CsvTable refuses, a place that cannot be touched, a negative width or time, a
// value along an axis that the object does not have, a history in time of a body at rest.
void AppendRows(const std::filesystem::path& file, Contact::Kind kind, const ObjectMesh& mesh,
                bool dynamic, std::vector<SolveRow>* rows);

// Says on stderr how many rows are extrapolated and why: a line per reason, with the first such
// row.
void TellDoubts(const std::vector<SolveRow>& rows);

// Writes one line per row with 17 significant digits, with `t` if they have one. False: the file
// cannot be written.
bool WriteRows(const std::filesystem::path& file, const std::vector<SolveRow>& rows);

}  // namespace palpate
