// Writes the table of rows and answers. It is separate from solve_rows.h, whose users do not need
// the protocol.
#pragma once

#include <filesystem>
#include <vector>

#include "slave/solve/solve_rows.h"

namespace palpate {

// Writes one line per row with 17 significant digits, including `t` if present, and the width or
// radius that was pressed with, so that AppendRows reads the same contacts. `moments`: also the
// moment of the force about the displaced centre of the contact, frame O [N m], empty where it is
// unknown. Answers with a stated error get the column `error`: of the force [N], of a load's
// displacement [m]. False: the file cannot be written.
bool WriteRows(const std::filesystem::path& file, const std::vector<SolveRow>& rows, bool moments);

}  // namespace palpate
