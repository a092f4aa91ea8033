#include <fstream>
#include <stdexcept>
#include <stop_token>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/study/report.h"
#include "slave/study/shard_file.h"
#include "tests/slave/study/fake_model_factory.h"
#include "tests/support/scratch.h"

namespace palpate::study {
namespace {

using testing::HasSubstr;

// A clock whose differences are exact in binary, so that no sum of times depends on its start. A
// quarter of the models costs a second, one kind has no solution.
struct ExactWorkshop {
  double clock = 1024;  // [s]
  int made = 0;

  ModelFactory Make() {
    return {[this](const Scene& scene, const ObjectMesh&, Progress*) {
              ++made;
              clock += scene.model.elements > 300 ? 1 : 0.125;
              const bool breaks =
                  scene.model.elements == 30 && scene.model.order == ElementOrder::kQuadratic;
              const double stiffness =
                  breaks ? kUnknown : 100 * (1 - 3.0 / scene.model.elements) / 3;
              return std::make_unique<fake::Spring>(
                  stiffness, std::ldexp(1, scene.model.elements > 100 ? -15 : -18), &clock);
            },
            [this] { return clock; }};
  }
};

// What a cost was expected to be follows from the candidates that ran before it.
StudyResult WithoutExpectations(StudyResult study) {
  for (StudyRow& row : study.rows) row.expected_s = 0;
  return study;
}

StudyResult Of(const std::vector<StudyRow>& rows) {
  StudyResult study;
  study.rows = rows;
  return WithoutExpectations(std::move(study));
}

class ShardTest : public testing::Test {
 protected:
  StudySettings settings_{.timing_s = std::ldexp(1, -10)};
  Scratch scratch_;

  StudyResult Run(const StudySettings& settings, const std::stop_token& stop = {},
                  const StudyWatcher& watcher = {}) {
    return RunStudy(fake::Square(), settings, workshop_.Make(), stop, watcher);
  }
  // Through a file, as another machine would hand it over.
  std::vector<StudyRow> Kept(StudyResult study) {
    const auto file = scratch_ / "shard.json";
    std::ofstream(file) << ToJson(ShardFile{{{"scene", "a"}}, "processor", std::move(study)});
    ShardFile read = ReadShard(file);
    EXPECT_EQ(read.conditions.at("scene"), "a");
    EXPECT_EQ(read.processor, "processor");
    return std::move(read.study.rows);
  }

  ExactWorkshop workshop_;
};

// Reference: the study that is not divided, byte by byte.
TEST_F(ShardTest, MergedShardsAreTheWholeStudyForAnyNumberOfThem) {
  const StudyResult whole = WithoutExpectations(Run(settings_));
  ASSERT_GE(whole.rows.size(), 15U);
  for (const std::size_t count :
       {std::size_t{1}, std::size_t{3}, std::size_t{8}, std::size_t{99}}) {
    StudySettings all = settings_;
    for (std::size_t index = 1; index <= count; ++index) {
      StudySettings part = settings_;
      part.shard = Shard{index, count};
      const auto rows = Kept(Run(part));
      EXPECT_LE(rows.size(), whole.rows.size() / count + 1);
      all.known.insert(all.known.end(), rows.begin(), rows.end());
    }
    const int before = workshop_.made;
    const StudyResult merged = WithoutExpectations(Run(all));
    EXPECT_EQ(workshop_.made, before) << "nothing is measured twice";
    EXPECT_TRUE(merged.complete);
    EXPECT_EQ(ToCsv(merged), ToCsv(whole)) << count;
    EXPECT_EQ(ToJson(merged), ToJson(whole));
    EXPECT_EQ(DrawFigure(merged), DrawFigure(whole));
    EXPECT_EQ(ToTable(merged), ToTable(whole));
  }
}

TEST_F(ShardTest, WhatWasMeasuredBeforeAnInterruptionIsNotMeasuredAgain) {
  settings_.shard = Shard{2, 3};
  const auto whole = Kept(Run(settings_));
  workshop_.made = 0;
  std::stop_source stop;
  const auto stop_later = [&](const StudyResult& so_far) {
    if (so_far.rows.size() == 4) stop.request_stop();
  };
  settings_.known = Kept(Run(settings_, stop.get_token(), {stop_later, nullptr}));
  EXPECT_EQ(workshop_.made, 4);
  std::erase_if(settings_.known,
                [](const StudyRow& row) { return row.outcome == Outcome::kSkipped; });
  EXPECT_EQ(settings_.known.size(), 4U);
  const auto continued = Kept(Run(settings_));
  EXPECT_EQ(workshop_.made, static_cast<int>(whole.size()));
  EXPECT_EQ(ToCsv(Of(continued)), ToCsv(Of(whole)));
}

TEST_F(ShardTest, RowsOfAnotherModelAreRefused) {
  settings_.known = Kept(Run(settings_));
  std::swap(settings_.known[0].number, settings_.known[1].number);
  EXPECT_THROW(Run(settings_), std::invalid_argument);
}

TEST_F(ShardTest, FilesThatAreNoShardsAreRefusedByName) {
  const auto file = scratch_ / "shard.json";
  const std::string good = ToJson(ShardFile{{}, "", Run(settings_)});
  for (const std::string& text :
       {std::string(), std::string("[]"), good.substr(0, good.size() / 2),
        std::string(R"({"conditions": {}, "processor": "", "study": {"complete": true,
                    "settings": {"budget_s": 1}, "rows": [{"number": -1}]}})")}) {
    std::ofstream(file) << text;
    try {
      ReadShard(file);
      ADD_FAILURE() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(file.string() + ": accepted is a file of study --shard"));
    }
  }
}

}  // namespace
}  // namespace palpate::study
