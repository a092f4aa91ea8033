// The rows of a contacts or loads file as contacts on a boundary mesh.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/mesh/outline.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

struct SolveRow {
  std::string case_name;  // rows of one case act together
  Contact contact;
  ContactResponse response;
  double solve_us = 0;
};

// Appends the rows of `file` (contracts, `solve`), each at the boundary element of its place.
// Throws InputError: what CsvTable refuses, a place farther than half an element from the boundary,
// a negative width, anything out of the plane, a history in time.
void AppendRows(const std::filesystem::path& file, Contact::Kind kind, const BoundaryMesh& mesh,
                std::vector<SolveRow>* rows);

// Writes one line per row with 17 significant digits. False: the file cannot be written.
bool WriteRows(const std::filesystem::path& file, const std::vector<SolveRow>& rows);

}  // namespace palpate
