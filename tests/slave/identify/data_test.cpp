// Laws and moduli from published tests (../shared/data; skipped where it is absent).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "shared/text/csv.h"
#include "slave/identify/chord_modulus.h"
#include "slave/identify/law_fit.h"
#include "slave/identify/prony.h"
#include "slave/identify/specimen_spread.h"
#include "slave/identify/specimen_table.h"
#include "slave/mechanics/relaxation/prony_series.h"
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
  CsvTable published(folder / "elastic_modulus_kPa.csv");
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

// The chord modulus of each sample of each material. Every interval is computed from sample A1
// alone, with the spread between specimens of the twelve other materials. It contains the modulus
// of sample B1 for 11 of 13 materials and is at most 15 % wide to each side. The published value is
// printed beside it.
TEST(SiliconeData, IntervalsOfOneSpecimenHoldTheOther) {
  const path folder = Data("silicone_compression");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  std::map<std::string, double> published;
  CsvTable rows(folder / "elastic_modulus_kPa.csv");
  while (rows.Next()) published[std::string(rows.Text(0))] = rows.Number(1, 1e9);
  const Specimen specimen{.height = 0.03, .diameter = 0.05, .bonded = true};
  struct Pair {
    std::string name;
    ChordModulus a, b;
  };
  std::vector<Pair> pairs;
  double square = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string stem = entry.path().stem().string();
    if (!stem.ends_with("_A1")) continue;
    const std::string name = stem.substr(0, stem.size() - 3);
    const auto chord = [&](const char* sample) {
      return *ChordModulusOf(ReadTest({"compression", folder / (name + sample)}, specimen));
    };
    pairs.push_back({name, chord("_A1.csv"), chord("_B1.csv")});
    square += std::pow(std::log(pairs.back().b.modulus / pairs.back().a.modulus), 2) / 2;
  }
  ASSERT_EQ(pairs.size(), 13U);
  EXPECT_NEAR(std::sqrt(square / 13), kBetweenSpecimens, 5e-4);
  std::ranges::sort(pairs, {}, &Pair::name);
  int covered = 0, with_published = 0;
  for (const Pair& pair : pairs) {
    const double own = std::pow(std::log(pair.b.modulus / pair.a.modulus), 2) / 2;
    const double others = std::sqrt((square - own) / 12 * 2);
    const double half = kSpecimenWide * std::hypot(others, pair.a.sigma / pair.a.modulus);
    EXPECT_LE(half, 0.15) << pair.name;
    const auto holds = [&](double modulus) {
      return std::abs(modulus / pair.a.modulus - 1) <= half;
    };
    covered += holds(pair.b.modulus);
    const auto found = published.find(pair.name);
    if (found != published.end()) with_published += holds(1e3 * found->second);
    std::printf("%-12s A1 %6.2f +- %4.1f %% kPa, B1 %6.2f, published %6.2f\n", pair.name.c_str(),
                1e-3 * pair.a.modulus, 100 * half, 1e-3 * pair.b.modulus,
                found == published.end() ? std::nan("") : found->second);
  }
  std::printf("intervals that hold B1: %d of 13, the published value: %d of %zu\n", covered,
              with_published, published.size());
  EXPECT_GE(covered, 11);
}

// Two specimens that differ more than those of the silicones widen the interval; two that agree
// narrow it, because the mean is better known.
TEST(SpecimenSpread, OfSeveralSpecimensCountsTheirOwn) {
  EXPECT_NEAR(OtherSpecimenSigma({}), kBetweenSpecimens * std::sqrt(2), 1e-12);
  EXPECT_EQ(OtherSpecimenSigma({}), OtherSpecimenSigma({5e4}));
  EXPECT_LT(OtherSpecimenSigma({5e4, 5e4, 5e4}), OtherSpecimenSigma({5e4}));
  EXPECT_GT(OtherSpecimenSigma({4e4, 5e4, 6e4}), OtherSpecimenSigma({5e4}));
}

void ExpectFits(const std::string& name, const std::vector<MaterialTest>& tests) {
  const LawFit best = FitLaws(tests).front();
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

// Rms error relative to the peak when the constants from one record of shear with holds predict the
// other records, computed as by a scene with material.relaxation. The three records with a stated
// rate are compared. The fourth and the monotonic ones have another stiffness: at the same strain
// and rate as the record of 2 the stress of the fourth is 1.7 times as large.
TEST(AdhesiveData, RelaxationAtOneRatePredictsTheOtherRates) {
  const path folder = Data("viscoelastic_adhesive");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  std::vector<RelaxationTable> records;
  for (const char* rate : {"0d1", "1", "2"}) {
    const path file = folder / (std::string("shear_relaxation_") + rate + ".csv");
    records.push_back(ReadRelaxation({"relaxation", file}, {}));
  }
  for (const RelaxationTable& fitted : records) {
    const PronyFit fit = FitProny({fitted});
    std::vector<RelaxationTerm> terms;
    for (const PronyTerm& term : fit.terms) {
      terms.push_back({term.modulus / fit.instant, term.time});
    }
    for (const RelaxationTable& record : records) {
      if (record.name == fitted.name) continue;
      RelaxationMemory memory;
      double squares = 0, peak = 0;
      for (std::size_t i = 0; i < record.time.size(); ++i) {
        Wrench elastic = Wrench::Zero();
        elastic[0] = fit.instant * record.strain[i];
        const PronySeries series(terms, i == 0 ? 1 : record.time[i] - record.time[i - 1]);
        const Wrench stress =
            i == 0 ? series.Jump(elastic, &memory) : series.Advance(elastic, &memory);
        squares += std::pow(stress[0] - record.stress[i], 2);
        peak = std::max(peak, record.stress[i]);
      }
      const double rms = std::sqrt(squares / static_cast<double>(record.time.size())) / peak;
      std::printf("%s predicts %s: rms %.1f %% of the peak\n", fitted.name.c_str(),
                  record.name.c_str(), 100 * rms);
      EXPECT_LT(rms, 0.1) << fitted.name << " of " << record.name;
    }
  }
}

}  // namespace
}  // namespace palpate::identify
