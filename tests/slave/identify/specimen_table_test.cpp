// Tables as written by machines and people, including faulty ones.
#include "slave/identify/specimen_table.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate::identify {
namespace {

using testing::Contains;
using testing::HasSubstr;

class TestTable : public FolderTest {
 protected:
  std::filesystem::path Write(const std::string& text) const {
    return FolderTest::Write("table.csv", text);
  }
  [[nodiscard]] MaterialTest Read(const std::string& kind, const std::string& text,
                                  const Specimen& specimen = {}) const {
    return ReadTest({kind, Write(text)}, specimen);
  }
  [[nodiscard]] std::string Complaint(const std::string& kind, const std::string& text,
                                      const Specimen& specimen = {}) const {
    return Thrown<std::exception>([&] { (void)Read(kind, text, specimen); });
  }
};

TEST_F(TestTable, RemarksUnitsForcesAndSignsOfAMachineAreUnderstood) {
  const Specimen specimen{.area = 4e-4, .height = 0.02};
  const MaterialTest test = Read("compression",
                                 "Sample 7\nSpeed (mm/min): 10;\n"
                                 "Time (s),Compression (mm),Load (N),Engineering Strain [-]\n"
                                 "0,0,0,0\n1,1,2,-0.05\n2,2,4,-0.1\n3,4,8,-0.2\n",
                                 specimen);
  ASSERT_EQ(test.rows.size(), 4U);
  EXPECT_DOUBLE_EQ(test.rows[3].abscissa, 0.8);
  EXPECT_DOUBLE_EQ(test.rows[3].measured[0], -8 / 4e-4);
}

// A neo-Hookean specimen of 30 kPa, stretched by up to 50 % in steps of 0.5 %, after `slack` of
// strain and with `at_rest` of load [Pa] more. Noise: 0.1 % of the largest load, alternating.
std::string Stretched(double slack, double at_rest) {
  std::string text = "strain (-),stress (Pa)\n";
  for (int i = 0; i <= 120; ++i) {
    const double strain = 0.005 * i, stretch = 1 + std::max(0.0, strain - slack);
    const double stress = 1e4 * (stretch - 1 / (stretch * stretch)) + at_rest;
    text += Formatted("%.6g,%.6g\n", strain, stress + (i % 2 == 0 ? 10 : -10));
  }
  return text;
}

// Tolerance: the noise, over the first step, is 0.2 % of strain.
void ExpectNeoHookean(const MaterialTest& test) {
  for (const TestRow& row : test.rows) {
    const double stretch = row.abscissa;
    if (stretch < 1) continue;
    EXPECT_NEAR(row.measured[0], 1e4 * (stretch - 1 / (stretch * stretch)), 3e4 * 0.003);
  }
}

TEST_F(TestTable, SlackAndTheLoadAtRestAreSubtracted) {
  for (const double slack : {0.0, 0.02, 0.1}) {
    for (const double at_rest : {0.0, 500.0, -1500.0}) {
      const MaterialTest test = Read("tension", Stretched(slack, at_rest));
      SCOPED_TRACE(Formatted("slack %g, at rest %g Pa", slack, at_rest));
      ExpectNeoHookean(test);
      std::string remarks;
      for (const std::string& remark : test.remarks) remarks += remark + "\n";
      EXPECT_EQ(remarks.find("slack of") != std::string::npos, slack > 0) << remarks;
      EXPECT_EQ(remarks.find("the load at rest") != std::string::npos, at_rest != 0) << remarks;
    }
  }
}

// A foam or a tissue that stiffens is not slack.
TEST_F(TestTable, ASoftBeginningIsNoSlack) {
  std::string text = "strain (-),stress (Pa)\n";
  for (int i = 0; i <= 100; ++i)
    text += Formatted("%g,%.8g\n", 0.005 * i, 10 * std::expm1(0.08 * i));
  const MaterialTest test = Read("tension", text);
  EXPECT_EQ(test.rows.size(), 101U);
  EXPECT_EQ(test.rows[0].abscissa, 1);
  ASSERT_EQ(test.remarks.size(), 1U);
  EXPECT_THAT(test.remarks[0], HasSubstr("the slope of the first rows is 0.6"));
}

// The stresses of the other kind of test (tension or compression): neo-Hookean, with Young's
// modulus 3e4 Pa.
TEST_F(TestTable, ACurveThatBendsAsTheOtherKindDrawsAQuestion) {
  const auto table = [](double sign) {
    std::string text = "strain (-),stress (Pa)\n";
    for (int i = 0; i <= 40; ++i) {
      const double stretch = 1 + sign * 0.0075 * i;
      text += Formatted("%g,%.8g\n", 0.0075 * i, sign * 1e4 * (stretch - 1 / (stretch * stretch)));
    }
    return text;
  };
  const std::string extended = table(1), pressed = table(-1);
  EXPECT_TRUE(Read("tension", extended).remarks.empty());
  EXPECT_TRUE(Read("compression", pressed).remarks.empty());
  EXPECT_THAT(Read("tension", pressed).remarks, Contains(HasSubstr("is it a compression")));
  EXPECT_THAT(Read("compression", extended).remarks, Contains(HasSubstr("is it a tension")));
}

TEST_F(TestTable, AStretchThatIsNamedStrainIsRejected) {
  for (const double to : {1.5, 0.7}) {
    std::string text = "strain,stress (Pa)\n";
    for (int i = 0; i <= 20; ++i) {
      const double stretch = 1 + (to - 1) * i / 20;
      text += Formatted("%g,%.8g\n", stretch, 1e4 * (stretch - 1 / (stretch * stretch)));
    }
    EXPECT_THAT(Complaint(to > 1 ? "tension" : "compression", text),
                HasSubstr("table.csv:2: column strain begins at 1, where the specimen bears no "
                          "load: is it a stretch, or in percent?"));
  }
}

TEST_F(TestTable, ATestThatIsUnloadedToTheEndKeepsItsBeginning) {
  std::string text = "strain (-),stress (Pa)\n";
  for (int i = 0; i <= 40; ++i)
    text += Formatted("%g,%g\n", 0.01 * std::min(i, 40 - i), 1e3 * std::min(i, 40 - i));
  const MaterialTest test = Read("tension", text);
  EXPECT_EQ(test.rows.size(), 41U);
  EXPECT_TRUE(test.remarks.empty());
}

// Text and numbers above the header, a column of text, unused cells.
TEST_F(TestTable, RemarksAndOtherColumnsAreReadPast) {
  const MaterialTest test =
      Read("tension",
           "Operator,Smith,Jones,Brown\nSpeed (mm/min),10\n"
           "Specimen,30,30,100\n12,8,2024,1\nState,Stretch,Stress (kPa),Temperature\n"
           "loading,1,0,\nloading,1.1,1,n/a\nloading,1.2,2,21\nhold,1.3,3,\n"
           "hold,1.4,4,\n");
  ASSERT_EQ(test.rows.size(), 5U);
  EXPECT_DOUBLE_EQ(test.rows[4].measured[0], 4e3);
  EXPECT_TRUE(test.units_named);
  EXPECT_FALSE(Read("tension", "stretch,stress\n1,0\n1.1,1\n1.2,2\n1.3,3\n").units_named);
}

// Reference: the same silicone specimen of 1.96e-3 m^2 and 30 mm in other units.
TEST_F(TestTable, ColumnsThatContradictEachOtherAreRefused) {
  const auto table = [](const char* header, double force, double stress) {
    std::string text = std::string(header) + "\n";
    for (int i = 0; i <= 10; ++i) {
      text += Formatted("%g,%g,%g,%g\n", 1.0 * i, force * i, i / 30.0, stress * i);
    }
    return text;
  };
  const std::string right = "Compression (mm),Load (N),Strain,Stress (kPa)";
  const Specimen sizes{.height = 0.03, .diameter = 0.05};
  EXPECT_EQ(Complaint("compression", table(right.c_str(), 4, 2.04)), "");
  EXPECT_EQ(Complaint("compression", table(right.c_str(), 4, 2.04), sizes), "");
  for (const char* wrong : {"Compression (mm),Load (N),Strain,Stress (Pa)",
                            "Compression (mm),Load (kN),Strain,Stress (kPa)",
                            "Compression (m),Load (N),Strain,Stress (kPa)"}) {
    EXPECT_THAT(Complaint("compression", table(wrong, 4, 2.04)), HasSubstr("Check the units"));
  }
  EXPECT_THAT(Complaint("compression",
                        table("Compression (mm),Load (mN),Strain,Stress (kPa)", 4, 2.04), sizes),
              HasSubstr("Check the units"));
}

// A rubber to eight times its length bends; the same numbers on a straight line are percent.
TEST_F(TestTable, AStrainWithoutAUnitIsPercentWhereTheCurveIsStraight) {
  std::string rubber = "strain,stress (kPa)\n", percent = rubber;
  for (int i = 0; i <= 70; ++i) {
    const double strain = 0.1 * i, stretch = 1 + strain, small = 1 + 0.01 * strain;
    rubber += Formatted("%g,%.8g\n", strain, 30 * (stretch - 1 / (stretch * stretch)));
    percent += Formatted("%g,%.8g\n", strain, 30 * (small - 1 / (small * small)));
  }
  EXPECT_THAT(Read("tension", rubber).remarks, testing::Contains(HasSubstr("write the unit %")));
  EXPECT_THAT(Complaint("tension", percent), HasSubstr("% (percent)"));
}

// Factors: NIST SP 811, 1 psi = 6894.757 Pa, 1 lbf = 4.448222 N, 1 kgf = 9.80665 N.
TEST_F(TestTable, UnitsOfOtherSystemsAreConverted) {
  const auto stress = [this](const std::string& header, const Specimen& specimen = {}) {
    return Read("tension", header + "\n0,0\n0.1,1\n0.2,2\n0.3,3\n", specimen).rows[3].measured[0];
  };
  const Specimen sizes{.area = 1e-4, .height = 1};
  EXPECT_NEAR(stress("Strain,Stress (psi)"), 3 * 6894.757, 0.01);
  EXPECT_NEAR(stress("Extension (m),Load (lbf)", sizes), 3 * 4.448222e4, 0.1);
  EXPECT_NEAR(stress("extension_m,force_kgf", sizes), 3 * 9.80665e4, 0.1);
  EXPECT_NEAR(stress("Extension / m,Force / gf", sizes), 3 * 9.80665e1, 1e-3);
  const Specimen inches{.area = 1e-4, .height = 0.0254};
  const MaterialTest inch =
      Read("tension", "Extension (in),Load (N)\n0,0\n0.1,1\n0.2,2\n0.3,3\n", inches);
  EXPECT_NEAR(inch.rows[3].abscissa, 1.3, 1e-12);
  for (const char* micro : {"\xC2\xB5m", "\xCE\xBCm", "\xB5m", "um"}) {
    const MaterialTest test =
        Read("tension", std::string("Extension (") + micro + "),Load (N)\n0,0\n1,1\n2,2\n3,3\n",
             {.area = 1e-4, .height = 10e-6});
    EXPECT_NEAR(test.rows[3].abscissa, 1.3, 1e-9) << micro;
  }
}

TEST_F(TestTable, TheUnitDeterminesTheQuantityOfAColumnInAnyBrackets) {
  Specimen specimen{.area = 1e-4, .height = 0.01};
  specimen.abscissa = "Standardweg [mm]";
  specimen.ordinate = "Standardkraft [N]";
  const MaterialTest german =
      Read("tension", "Standardweg [mm],Standardkraft [N]\n0,0\n1,1\n2,2\n3,3\n", specimen);
  EXPECT_DOUBLE_EQ(german.rows[3].abscissa, 1.3);
  EXPECT_DOUBLE_EQ(german.rows[3].measured[0], 3e4);
  Specimen named;
  named.abscissa = "Tensile strain (Extension) (%)";
  const MaterialTest two = Read("tension",
                                "Tensile strain (Extension) (%),Stress (MPa)\n"
                                "0,0\n10,1\n20,2\n30,3\n",
                                named);
  EXPECT_DOUBLE_EQ(two.rows[3].abscissa, 1.3);
}

TEST_F(TestTable, UnitsThatAreUnknownOrContradictTheNameAreRefused) {
  const std::string rows = "\n0,0\n0.1,1\n0.2,2\n0.3,3\n";
  EXPECT_THAT(Complaint("tension", "strain,stress (kips/in2)" + rows),
              HasSubstr("column stress (kips/in2): expected a stress in Pa"));
  EXPECT_THAT(Complaint("tension", "strain,stress (N)" + rows),
              HasSubstr("column stress (N): expected a stress"));
  EXPECT_THAT(Complaint("tension", "strain (mm),stress" + rows),
              HasSubstr("column strain (mm): expected a number without dimension"));
  Specimen specimen;
  specimen.ordinate = "force (MPa)";
  EXPECT_THAT(Complaint("tension", "strain,force (MPa)" + rows, specimen),
              HasSubstr("column force (MPa): expected a force"));
  specimen = {};
  specimen.abscissa = "True strain";
  EXPECT_THAT(Complaint("tension", "True strain,stress (kPa)" + rows, specimen),
              HasSubstr("column True strain: expected engineering strain"));
}

TEST_F(TestTable, TrueStressAndTensorsAreKnownByTheirColumns) {
  EXPECT_TRUE(Read("tension", "stretch,sigma11\n1,0\n1.1,1\n1.2,2\n1.3,3\n").cauchy);
  const std::string header =
      "stretch,F11,F12,F13,F21,F22,F23,F31,F32,F33,P11,P12,P13,P21,P22,P23,P31,P32,P33\n";
  std::string rows;
  for (const char* gamma : {"0", "0.1", "0.2", "0.3"}) {
    rows += std::string(gamma) + ",1," + gamma + ",0,0,1,0,0,0,1,0," + gamma + ",0,0,0,0,0,0,0\n";
  }
  const MaterialTest shear = Read("", header + rows);
  ASSERT_EQ(shear.components.size(), 1U);
  EXPECT_EQ(shear.components[0], std::pair(0, 1));
  EXPECT_EQ(shear.rows[3].F(0, 1), 0.3);
}

TEST_F(TestTable, ManyRowsAreAveraged) {
  std::string text = "strain,stress\n";
  for (int i = 0; i < 5000; ++i) text += Formatted("%.6f,%.6f\n", 1e-4 * i, 1.0 * i);
  const MaterialTest test = Read("tension", text);
  EXPECT_LE(test.rows.size(), 240U);
  EXPECT_NEAR(test.rows.back().measured[0] / (test.rows.back().abscissa - 1), 1e4, 1e-6);
}

TEST_F(TestTable, OfTooFewRowsCanBeDistinguishedFromABadOne) {
  const std::string three = "strain,stress\n0,0\n.1,1\n.2,2\n";
  EXPECT_THROW((void)Read("tension", three), TooFewRows);
  const std::string hold = "t,shear,stress\n0,0,0\n1,.1,1\n2,.1,1\n";
  EXPECT_THROW(ReadRelaxation({"relaxation", Write(hold)}, {}), TooFewRows);
  const RelaxationTable table = ReadRelaxation({"relaxation", Write(hold + "3,.1,1\n")}, {});
  EXPECT_TRUE(table.shear);
}

// A specimen of 30 mm and 100 kPa, whose first row has `travel` mm and `load` N.
std::string Travel(double travel, double load) {
  std::string text = "Extension (mm),Load (N)\n";
  for (int i = 0; i <= 30; ++i) {
    text += Formatted("%.4f,%.6f\n", travel + 0.2 * i, load + 196.3495 * 0.2 * i / 30);
  }
  return text;
}

TEST_F(TestTable, TheTravelOfAFirstRowWithoutALoadIsSubtracted) {
  const Specimen specimen{.height = 0.03, .diameter = 0.05};
  for (const double travel : {0.2, 0.5, 1.0, 2.05, -0.4}) {
    const MaterialTest test = Read("compression", Travel(travel, 0), specimen);
    const auto last = static_cast<double>(test.rows.back().measured[0]);
    EXPECT_NEAR(last / (test.rows.back().abscissa - 1), 1e5, 100) << travel;
    EXPECT_THAT(test.remarks, Contains(HasSubstr("offset of the travel"))) << travel;
  }
  EXPECT_THAT(Read("compression", Travel(0, 0), specimen).remarks, testing::IsEmpty());
  // A table that begins on the curve has no offset.
  const MaterialTest later = Read("compression", Travel(0.2, 196.3495 * 0.2 / 30), specimen);
  EXPECT_NEAR(later.rows.back().measured[0] / (later.rows.back().abscissa - 1), 1e5, 100);
  EXPECT_THAT(later.remarks, testing::IsEmpty());
  // With half of the load it is unknown whether load or travel is wrong.
  EXPECT_THAT(Read("compression", Travel(1, 196.3495 * 0.45 / 30), specimen).remarks,
              Contains(HasSubstr("which the table cannot tell")));
}

// Loading at 100 kPa, unloading below it, and a second loading that is softer.
std::string Cycles(double hysteresis, double softening) {
  std::string text = "strain,stress_kPa\n";
  const auto leg = [&](bool loading, double softer) {
    for (int i = 0; i <= 20; ++i) {
      const double e = 0.01 * (loading ? i : 20 - i);
      const double lower = loading ? 0 : hysteresis * e * (0.2 - e) / 0.01;
      text += Formatted("%.4f,%.6f\n", e, 100 * e * (1 - softer) * (1 - lower));
    }
  };
  leg(true, 0), leg(false, 0), leg(true, softening), leg(false, softening);
  return text;
}

TEST_F(TestTable, TheFirstLoadingOfCyclesThatDifferIsKept) {
  const MaterialTest same = Read("tension", Cycles(0, 0));
  EXPECT_EQ(same.rows.size(), 84U);
  EXPECT_THAT(same.remarks, testing::IsEmpty());
  for (const auto& [hysteresis, softening, words] :
       {std::tuple{0.3, 0.0, "loading and unloading by"},
        {0.0, 0.3, "loadings by"},
        {0.3, 0.3, "loading and unloading, and loadings,"}}) {
    const MaterialTest test = Read("tension", Cycles(hysteresis, softening));
    EXPECT_EQ(test.rows.size(), 21U) << words;
    EXPECT_NEAR(test.rows.back().measured[0] / 0.2, 1e5, 1) << words;
    EXPECT_THAT(test.remarks, Contains(HasSubstr(words)));
    EXPECT_THAT(test.remarks, Contains(HasSubstr("loading 100 kPa"))) << words;
  }
}

TEST_F(TestTable, NamesThatOccurTwiceAreRefusedUnlessTheyAreTheSameNumbers) {
  const std::string rows = "0,0,0,0\n.1,1,.1,2\n.2,2,.2,4\n.3,3,.3,6\n";
  EXPECT_THAT(Complaint("tension", "strain,stress,strain,stress\n" + rows),
              HasSubstr("the name stress occurs twice, as column 2 and column 4"));
  const MaterialTest both = Read("tension",
                                 "strain,stress (kPa),Strain,Stress (Pa)\n"
                                 "0,0,0,0\n.1,1,.1,1000\n.2,2,.2,2000\n.3,3,.3,3000\n");
  EXPECT_DOUBLE_EQ(both.rows[3].measured[0], 3000);
}

TEST_F(TestTable, AClockThatRunsBackIsRemarked) {
  const std::string head = "time (s),strain,stress (kPa)\n", rows = "1,.1,1\n2,.2,2\n3,.3,3\n";
  EXPECT_THAT(Read("tension", head + "0,0,0\n" + rows).remarks, testing::IsEmpty());
  EXPECT_THAT(Read("tension", head + "0,0,0\n" + rows + "0,0,0\n" + rows).remarks,
              Contains(HasSubstr("the time runs back in line 6")));
}

// As written by instruments: a row of units, including units of unused columns.
TEST_F(TestTable, ARowOfUnitsBelowTheNamesIsNoRowOfNames) {
  const std::string head =
      "Step time\tTemperature\tStress\tShear strain\tRelaxation modulus\n"
      "s\t\xC2\xB0"
      "C\tPa\t%\tPa\n";
  std::string rows;
  for (int i = 1; i <= 6; ++i) rows += Formatted("%d\t25\t%d\t2.0\t1\n", i, 100 - i);
  const RelaxationTable table = ReadRelaxation({"relaxation", Write(head + rows)}, {});
  EXPECT_TRUE(table.shear);
  EXPECT_DOUBLE_EQ(table.strain.front(), 0.02);
  EXPECT_DOUBLE_EQ(table.stress.front(), 99);
  std::string plain = head;
  plain.replace(plain.find("Shear s"), 7, "S");
  EXPECT_THAT(Thrown<InputError>([&] {
                (void)ReadRelaxation({"relaxation", Write(plain + rows)}, {});
              }),
              HasSubstr("it may be a shear: expected the name Shear strain"));
}

TEST_F(TestTable, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(Complaint("tension", "a,b\n1,2\n1,2\n1,2\n1,2\n"), HasSubstr("no deformation"));
  EXPECT_THAT(Complaint("tension", "strain,b\n1,2\n1,2\n1,2\n1,2\n"), HasSubstr("no load"));
  EXPECT_THAT(Complaint("tension", "strain,stress\n0,0\n0.1,much\n"),
              HasSubstr(".csv:3: stress = much"));
  const std::string one = "strain,stress\n0,0\n.1,1\n.2,2\n.3,3\n.4,4\n";
  EXPECT_THAT(Complaint("tension", one + "\n" + one), HasSubstr(":8: a second header"));
  EXPECT_THAT(Complaint("tension", "strain,stress\n0,0\n0.1\n"), HasSubstr(":3: 1 cells"));
  EXPECT_THAT(Complaint("tension", "strain,stress\n0,0\n-1.5,1\n0,0\n0,0\n"),
              HasSubstr(":3: stretch = -0.5"));
  EXPECT_THAT(Complaint("tension", "strain,stress\n0,0\n0.1,1\n"), HasSubstr("expected 4"));
  EXPECT_THAT(Complaint("tension", "0,0\n0.1,1\n"), HasSubstr("without a header"));
  EXPECT_THAT(Complaint("tension", "strain,stress\n0,0\n.1,0\n.2,0\n.3,0\n"),
              HasSubstr("every stress is zero"));
  EXPECT_THAT(Complaint("tension", "strain,force\n0,0\n.1,1\n.2,2\n.3,3\n"), HasSubstr("--area"));
  EXPECT_THAT(Complaint("tension", "displacement,stress\n0,0\n.1,1\n.2,2\n.3,3\n"),
              HasSubstr("--height"));
  EXPECT_THAT(Complaint("bending", "strain,stress\n0,0\n"), HasSubstr("expected uniaxial"));
  EXPECT_THAT(Complaint("biaxial", "stretch,stress\n1,0\n1.1,1\n1.2,2\n1.3,3\n"),
              HasSubstr("second stretch"));
  EXPECT_THAT(Complaint("tension", ""), HasSubstr("no header"));
  EXPECT_THAT(Complaint("tension", "strain,stress\n0,0\nnan,1\n0,0\n0,0\n"), HasSubstr(":3:"));
  EXPECT_THAT(Complaint("compression", "strain,stress\n0,0\n.1,1\n.2,2\n.3,3\n", {.bonded = true}),
              HasSubstr("--diameter"));
}

}  // namespace
}  // namespace palpate::identify
