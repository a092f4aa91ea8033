#include "shared/text/csv.h"

#include <clocale>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

std::string Written(double value, int digits) {
  std::string text;
  AppendNumber(&text, value, digits);
  return text;
}

TEST(AppendNumberTest, SeventeenDigitsRoundTrip) {
  for (const double value : {0.1, -1.0 / 3, 1e-300, 1.7976931348623157e308}) {
    EXPECT_EQ(std::stod(Written(value, 17)), value);
  }
}

TEST(AppendNumberTest, UnknownNumbersAreEmptyAndZeroHasNoSign) {
  EXPECT_EQ(Written(std::nan(""), 7), "");
  EXPECT_EQ(Written(INFINITY, 7), "");
  EXPECT_EQ(Written(-0.0, 7), "0");
  EXPECT_EQ(Written(0.25, 7), "0.25");
}

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

std::filesystem::path Write(const std::string& text) {
  static const Scratch scratch;
  return scratch.Write("table.csv", text);
}

TEST(CsvLinesTest, SkipsLinesThatAreNoRows) {
  CsvLines lines(Write("\xEF\xBB\xBF a , b\r\n\n# c\n,1,\n2"));
  ASSERT_TRUE(lines.Next());
  EXPECT_THAT(lines.cells(), testing::ElementsAre("a", "b"));
  ASSERT_TRUE(lines.Next());
  EXPECT_THAT(lines.cells(), testing::ElementsAre("", "1", ""));
  EXPECT_EQ(lines.number(), 4);
  ASSERT_TRUE(lines.Next());
  EXPECT_EQ(lines.text(), "2");
  EXPECT_FALSE(lines.Next());
  CsvLines plain(Write("#1,2\n"), 0);
  ASSERT_TRUE(plain.Next());
  EXPECT_EQ(plain.cells().front(), "#1");
}

TEST(CsvLinesTest, JsonIsNamed) {
  for (const char* text : {"{\"t\": 0, \"x\": 1}\n", "[{\"t\": 0}]", " [[0, 1], [1, 2]]"}) {
    EXPECT_THAT(Thrown<InputError>([&] { CsvLines lines(Write(text)); }),
                HasSubstr("is JSON: save the table as CSV"));
  }
  EXPECT_NO_THROW(CsvLines(Write("[step]\nt,x\n0,1\n")));
}

TEST(CsvLinesTest, TwoQuotesWithinACellAreOne) {
  CsvLines lines(Write("\"a \"\"word\"\" in quotes\", \"\" , \"b, c\",\"x\"\"\"\n"));
  ASSERT_TRUE(lines.Next());
  EXPECT_THAT(lines.cells(), testing::ElementsAre("a \"word\" in quotes", "", "b, c", "x\""));
}

// Devices and endless pipes can be read as files, too: at most one line is held in memory.
TEST(CsvLinesTest, ReadsNoLineWithoutEnd) {
  CsvLines zeros("/dev/zero");
  EXPECT_EQ(Thrown<InputError>([&] { zeros.Next(); }),
            "/dev/zero:1: a line of 64 KiB or more: expected a CSV file");
  EXPECT_THAT(Thrown<InputError>([] { CsvLines{testing::TempDir()}; }),
              HasSubstr("cannot be read"));
  EXPECT_THAT(Thrown<InputError>([] { CsvLines("/nowhere.csv"); }), HasSubstr("cannot be read"));
}

TEST(CsvTableTest, FindsColumnsAndQuotesNothingThatMovesTheCursor) {
  CsvTable rows(Write("t,x,\n0,+1.5,\n1,\x1b[2J\n1\n"));
  ASSERT_TRUE(rows.Next());
  EXPECT_EQ(rows.Number(*rows.Find("x"), 2), 1.5);
  EXPECT_THAT(Thrown<InputError>([&] { static_cast<void>(rows.Number(1, 1)); }),
              EndsWith(".csv:2: x = +1.5: expected a finite number up to 1"));
  ASSERT_TRUE(rows.Next());
  EXPECT_THAT(Thrown<InputError>([&] { rows.Refuse(1, "a number"); }),
              EndsWith(":3: x = ?[2J: expected "
                       "a number"));
  EXPECT_THAT(Thrown<InputError>([&] { rows.Next(); }),
              EndsWith(":4: 1 cells: expected 2, as in the header"));
  EXPECT_THAT(Thrown<InputError>([] { CsvTable(Write("a,a\n")); }),
              HasSubstr("column a appears twice"));
}

// The same row in the formats of other programs. Reference: the row itself.
TEST(CsvTableTest, ADialectDoesNotChangeTheNumbers) {
  std::string utf16 = "\xFF\xFE";
  for (const char c : std::string("name,x,y\r\na,0.5,-2\r\n")) (utf16 += c) += '\0';
  for (const std::string& text :
       {std::string("name,x,y\na,0.5,-2\n"), std::string("name;x;y\r\na;0,5;-2\r\n"),
        std::string("name\tx\ty\na\t0,5\t-2"), std::string("name,x,y\ra,0.5,-2\r"),
        std::string("\"name\",\"x\",\"y\"\n\"a\",\"0.5\",\"-2\"\n"),
        std::string("\xEF\xBB\xBFname,x,y,,\na,0.5,-2,,\n"), std::string(",name,x,y\n0,a,0.5,-2\n"),
        std::string("\tname\tx\ty\n0\ta\t0.5\t-2\n"), std::string("name,x (mm),y (m)\na,500,-2\n"),
        std::string("name,x,y\n,mm,m\na,500,-2\n"), std::string("name,x (\xB5m),y\na,500000,-2\n"),
        utf16}) {
    CsvTable table(Write(text));
    ASSERT_TRUE(table.Next()) << text;
    EXPECT_EQ(table.Text("name"), "a") << text;
    EXPECT_DOUBLE_EQ(table.Number("x"), 0.5) << text;
    EXPECT_EQ(table.Number("y"), -2) << text;
    EXPECT_FALSE(table.Next()) << text;
  }
}

TEST(CsvTableTest, TwoColumnsWithDecimalCommasAreTakenApartBySemicolons) {
  CsvTable table(Write("Weg;Kraft\nmm;N\n0,2000;12,3456\n0,4000;24,5000\n"));
  ASSERT_TRUE(table.Next());
  EXPECT_DOUBLE_EQ(table.Number("Weg"), 0.2e-3);
  EXPECT_DOUBLE_EQ(table.Number("Kraft"), 12.3456);
}

TEST(CsvTableTest, ANumberThatMayMeanTwoThingsIsRefused) {
  const auto refusal = [](const std::string& text) {
    return Thrown<InputError>([&] {
      CsvTable table(Write(text), {{"x"}, {"y"}});
      while (table.Next()) static_cast<void>(table.Number("x"));
    });
  };
  EXPECT_THAT(refusal("x,y\n\"1,5\",2\n"), HasSubstr(":2: 1,5: a comma in a number"));
  EXPECT_THAT(refusal("x;y\n1,5;0.5\n"), HasSubstr("decimal commas and decimal points"));
  EXPECT_THAT(refusal("x,y\n1,5,2,5\n"), HasSubstr("4 cells: expected 2"));
  EXPECT_THAT(refusal("x;y\n1.234,5;2\n"), HasSubstr("a finite number"));
  EXPECT_THAT(refusal("x,y\n\"1,2\n"), HasSubstr("a quote that is not closed"));
  EXPECT_THAT(refusal("x (ft),y\n1,2\n"), HasSubstr("unit ft is not understood"));
}

TEST(CsvTableTest, AnUnknownUnitOrColumnIsRefusedWithAndWithoutARequiredHeader) {
  for (const auto header : {CsvTable::Header::kRequired, CsvTable::Header::kOptional}) {
    const auto refusal = [&](const std::string& text) {
      return Thrown<InputError>([&] {
        CsvTable(Write(text), {{"x", true, Quantity::kLength}, {"y"}}, header);
      });
    };
    EXPECT_THAT(refusal("x (ells),y\n1,2\n"), HasSubstr("unit ells is not understood"));
    EXPECT_THAT(refusal("x,y,w\n1,2,3\n"), HasSubstr("column = w: expected x,y"));
    EXPECT_THAT(refusal("x (N),y\n1,2\n"), HasSubstr("a unit of another quantity"));
  }
  CsvTable table(Write("X / thou,y\n1000,2\n"), {{"x", true, Quantity::kLength}, {"y"}},
                 CsvTable::Header::kOptional);
  ASSERT_TRUE(table.Next());
  EXPECT_DOUBLE_EQ(table.Number("x"), 0.0254);
}

TEST(CsvTableTest, TimesInNanosecondsAreConvertedWhereTheyAreNamedAndExplainedWhereNot) {
  CsvTable plain(Write("t\n1762000000020000000\n")), named(Write("t (ns)\n1762000000020000000\n"));
  ASSERT_TRUE(plain.Next() && named.Next());
  EXPECT_THAT(Thrown<InputError>([&] { static_cast<void>(plain.Number(0, 1e12)); }),
              AllOf(HasSubstr("nanoseconds since 1970"), HasSubstr("t (ns)")));
  EXPECT_NEAR(named.Number(0, 1e12), 1762000000.02, 1e-6);
}

}  // namespace
}  // namespace palpate
