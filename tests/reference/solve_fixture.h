// Runs `solve` on a scene and tables given as text, and reads the answers back.
#pragma once

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

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
    std::ifstream stream(options.out);
    std::vector<std::string> names;
    std::vector<std::map<std::string, double>> rows;
    for (std::string line; std::getline(stream, line);) {
      std::stringstream cut(line);
      std::vector<std::string> cells;
      for (std::string cell; std::getline(cut, cell, ',');) cells.push_back(cell);
      if (names.empty()) {
        names = cells;
        continue;
      }
      auto& row = rows.emplace_back();
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == "case" || names[i] == "validity") continue;
        row[names[i]] = cells[i].empty() ? std::nan("") : std::stod(cells[i]);
      }
    }
    return rows;
  }
};

}  // namespace palpate
