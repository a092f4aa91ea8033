// Runs `solve` on a scene and tables given as text, and reads the answers back.
#pragma once

#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "shared/text/csv.h"
#include "slave/commands/solve/solve.h"
#include "tests/support/scratch.h"

namespace palpate {

inline std::string Text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

class SolveFiles : public FolderTest {
 protected:
  // Runs and returns the rows as numbers by column; an empty cell is NaN, validity is left out.
  std::vector<std::map<std::string, double>> Solve(const std::string& scene,
                                                   const std::string& contacts,
                                                   const std::string& loads) {
    SolveOptions options;
    options.scene = Write("scene.yaml", scene);
    if (!contacts.empty()) options.contacts = Write("contacts.csv", contacts);
    if (!loads.empty()) options.loads = Write("loads.csv", loads);
    options.out = folder_ / "out.csv";
    testing::internal::CaptureStderr();
    const int exit_code = RunSolve(options);
    const std::string message = testing::internal::GetCapturedStderr();
    EXPECT_EQ(exit_code, 0) << message << scene;
    std::vector<std::string> names;
    std::vector<std::map<std::string, double>> rows;
    for (CsvLines lines(options.out); lines.Next();) {
      const auto& cells = lines.cells();
      if (names.empty()) {
        names.assign(cells.begin(), cells.end());
        continue;
      }
      auto& row = rows.emplace_back();
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == "case" || names[i] == "validity") continue;
        row[names[i]] = cells[i].empty() ? std::nan("") : std::stod(std::string(cells[i]));
      }
    }
    return rows;
  }
};

}  // namespace palpate
