// Laws and moduli from published tests (../shared/data; skipped where it is absent).
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "shared/text/csv.h"
#include "slave/identify/chord_modulus.h"
#include "slave/identify/law_fit.h"
#include "slave/identify/prediction.h"
#include "slave/identify/test_table.h"
#include "tests/support/paths.h"

namespace palpate::identify {
namespace {

using std::filesystem::path;

path Data(const std::string& folder) {
  return SourcePath("/../shared/data/" + folder);
}

std::vector<MaterialTest> Tests(const path& folder,
                                const std::vector<std::pair<std::string, std::string>>& kinds,
                                const Specimen& specimen = {}) {
  std::vector<MaterialTest> tests;
  for (const auto& [kind, file] : kinds) {
    tests.push_back(ReadTest({kind, folder / (file + ".csv")}, specimen));
  }
  return tests;
}

// The chord modulus of A1 and B1 with bonded ends, in the mean, against the publication's: 15 % for
// 9 of 11.
TEST(SiliconeData, ChordModuliAreThePublishedOnes) {
  const path folder = Data("silicone_compression");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const Specimen specimen{.height = 0.03, .diameter = 0.05, .bonded = true};
  CsvRows published(folder / "elastic_modulus_kPa.csv");
  int near = 0, all = 0;
  while (published.Next()) {
    const std::string name(published.Text(0));
    double mean = 0;
    for (const char* sample : {"_A1.csv", "_B1.csv"}) {
      const MaterialTest test = ReadTest({"compression", folder / (name + sample)}, specimen);
      mean += 0.5e-3 * ChordModulusOf(test)->modulus;
    }
    const double ratio = mean / published.Number(1, 1e9);
    near += std::abs(ratio - 1) <= 0.15;
    ++all;
    RecordProperty(name, std::to_string(ratio));
  }
  EXPECT_EQ(all, 11);
  EXPECT_GE(near, 9);
}

void ExpectFits(const std::string& name, const std::vector<MaterialTest>& tests,
                bool foam = false) {
  const LawFit best = FitLaws(tests, foam).front();
  EXPECT_EQ(best.unstable, "") << name;
  EXPECT_LT(best.rms, 0.05) << name << " by " << best.law.name;
  ::testing::Test::RecordProperty(name,
                                  best.law.name + " " + std::to_string(100 * best.rms) + " %");
}

TEST(HyperelasticData, RubberAndGelAreFittedWithinFivePercent) {
  const path folder = Data("hyperelastic_curves");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const std::vector<std::pair<std::string, std::string>> three{
      {"uniaxial", "UT"}, {"equibiaxial", "ET"}, {"planar", "PS"}};
  for (const char* material : {"Treloar_1944", "Kawabata_1981", "Meunier_2008"}) {
    ExpectFits(material, Tests(folder / material, three));
  }
  ExpectFits("Katashima_2012",
             Tests(folder / "Katashima_2012", {{"equibiaxial", "ET"}, {"planar", "PS"}}));
  for (const std::string tissue : {"cortex", "corona_radiata"}) {
    ExpectFits(tissue, Tests(folder / "Budday_2017", {{"tension", "UT_T_" + tissue},
                                                      {"compression", "UT_C_" + tissue},
                                                      {"shear", "SS_" + tissue}}));
  }
}

TEST(FoamData, IsFittedWithinFivePercent) {
  const path folder = Data("foam_curves/foam_leap");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  ExpectFits("foam_leap",
             Tests(folder, {{"tension", "UT"}, {"compression", "UC"}, {"shear", "SS"}}), true);
}

struct Cover {
  int rows = 0, covered = 0;
  double widest = 0, mean_width = 0;  // over the material's peak
};

Cover CoverOf(const std::vector<MaterialTest>& known, const std::vector<MaterialTest>& others) {
  const Predictor predictor(known);
  Cover cover;
  double peak = 0;
  for (const auto* tests : {&known, &others}) {
    for (const MaterialTest& test : *tests) peak = std::max(peak, test.Peak());
  }
  for (const MaterialTest& test : others) {
    for (std::size_t i = 0; i < test.rows.size(); ++i) {
      const PredictedRow row = predictor.At(test, i);
      const double measured = test.rows[i].measured[0];
      ++cover.rows;
      cover.covered += row.low <= measured && measured <= row.high;
      cover.widest = std::max(cover.widest, (row.high - row.low) / peak);
      cover.mean_width += (row.high - row.low) / peak;
    }
  }
  cover.mean_width /= cover.rows;
  return cover;
}

// Rubber and silicone, fitted on uniaxial data alone: the band over the other tests is in the mean
// narrower than a quarter of the peak and holds nine of ten rows.
TEST(HyperelasticData, UniaxialTestsAlonePredictTheOthers) {
  const path folder = Data("hyperelastic_curves");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  int rows = 0, covered = 0;
  for (const char* material : {"Treloar_1944", "Kawabata_1981", "Meunier_2008"}) {
    const Cover cover =
        CoverOf(Tests(folder / material, {{"uniaxial", "UT"}}),
                Tests(folder / material, {{"equibiaxial", "ET"}, {"planar", "PS"}}));
    RecordProperty(material, Formatted("%d of %d, widest %.3f, mean %.3f", cover.covered,
                                       cover.rows, cover.widest, cover.mean_width));
    EXPECT_LT(cover.mean_width, 0.25) << material;
    rows += cover.rows, covered += cover.covered;
  }
  EXPECT_GE(covered, 0.9 * rows);
}

}  // namespace
}  // namespace palpate::identify
