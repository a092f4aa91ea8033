#include "slave/study/report.h"

#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/slave/study/fake_model_factory.h"
#include "tests/support/scratch.h"

namespace palpate::study {
namespace {

// Answered, failed and skipped rows.
StudyResult Mixed() {
  fake::Scenario scenario;
  scenario.stiffness = [](const Scene& scene) -> double {
    if (scene.model.elements == 120) throw std::runtime_error("no, \"really\"\nnot");
    return 100 * (1 - 3.0 / scene.model.elements);
  };
  scenario.precompute = [](const Scene& scene) {
    return 3 * std::pow(scene.model.elements / 300., 3);
  };
  return RunStudy(fake::Square(), {.budget_s = 40, .timing_s = 1e-4}, scenario.Make());
}

// Splits a line into its cells and removes their quotes.
std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells{""};
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += line[i++];
    } else if (line[i] == '"') {
      quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  return cells;
}

TEST(ReportTest, CsvHasItsDocumentedHeaderAndNumbersThatRoundTrip) {
  const StudyResult study = Mixed();
  std::stringstream csv(ToCsv(study));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "family,kind,resolution,dof,residual,outcome,error,error_bar,error_small,"
            "error_small_bar,deviation,plane_error,validity,update_median_s,update_p99_s,"
            "precompute_s,memory_bytes,expected_s,own,on_front,meets_tolerance,meets_rate,"
            "recommended,reason");
  const std::size_t columns = Cells(line).size();
  for (const StudyRow& row : study.rows) {
    ASSERT_TRUE(std::getline(csv, line));
    const auto cells = Cells(line);
    ASSERT_EQ(cells.size(), columns) << line;
    EXPECT_EQ(cells[0], row.family);
    EXPECT_EQ(cells[5], ToString(row.outcome));
    if (row.outcome == Outcome::kAnswered) {
      EXPECT_EQ(std::stod(cells[6]), row.error.value);
      EXPECT_EQ(std::stod(cells[13]), row.update_median_s);
      EXPECT_EQ(cells[12], "valid");
    } else {
      EXPECT_EQ(cells[6], "") << "not known is empty";
      EXPECT_NE(cells[22], "");
    }
  }
  EXPECT_FALSE(std::getline(csv, line));
}

TEST(ReportTest, FilesAreCompleteAfterEveryRowSoThatAnInterruptionKeepsThem) {
  const Scratch folder;
  fake::Scenario scenario;
  std::stop_source stop;
  std::size_t rows = 0;
  const StudyWatcher watcher{[&](const StudyResult& so_far) {
                               WriteStudy(so_far, folder.path());
                               const auto json =
                                   nlohmann::json::parse(Scratch::Read(folder / "study.json"));
                               EXPECT_EQ(json.at("rows").size(), so_far.rows.size());
                               if (++rows == 3) stop.request_stop();
                             },
                             nullptr};
  const StudyResult study =
      RunStudy(fake::Square(), {.timing_s = 1e-4}, scenario.Make(), stop.get_token(), watcher);
  EXPECT_EQ(Scratch::Read(folder / "study.csv"), ToCsv(study))
      << "the last one lists what was skipped too";
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_NE(entry.path().extension(), ".part");
    ++files;
  }
  EXPECT_EQ(files, 2);
}

}  // namespace
}  // namespace palpate::study
