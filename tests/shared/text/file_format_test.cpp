#include "shared/text/file_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using namespace std::string_view_literals;

// References: the documents of the formats (magic numbers).
TEST(FileFormatTest, FilesOfOtherProgramsAreNamedWithTheWayToConvertThem) {
  const std::string zip = "PK\x03\x04" + std::string(26, '\0');
  EXPECT_THAT(ForeignFormat(zip + "[Content_Types].xml"),
              AllOf(HasSubstr("workbook"), HasSubstr("CSV")));
  EXPECT_THAT(ForeignFormat(zip + "a.npy"), HasSubstr("NumPy"));
  EXPECT_THAT(ForeignFormat(zip + "net/data.pkl"), HasSubstr("palpate.convert_network"));
  EXPECT_THAT(ForeignFormat(zip + "letter.txt"), HasSubstr("unzip"));
  EXPECT_THAT(ForeignFormat("SQLite format 3\0abc"sv),
              AllOf(HasSubstr("rosbag2"), HasSubstr("MCAP")));
  EXPECT_THAT(ForeignFormat("II*\0\x08\0\0\0"sv),
              AllOf(HasSubstr("TIFF"), HasSubstr("16-bit PNG")));
  EXPECT_THAT(ForeignFormat("$NOD\n4\n"),
              AllOf(HasSubstr("Gmsh mesh of format 1"), HasSubstr("-save")));
  EXPECT_THAT(ForeignFormat("\x28\xB5\x2F\xFD...."sv), HasSubstr("zstd -d"));
  EXPECT_THAT(ForeignFormat("PAR1...."), HasSubstr("Parquet"));
  EXPECT_THAT(ForeignFormat("<!DOCTYPE html><html>"), HasSubstr("web page"));
  EXPECT_THAT(ForeignFormat("\0\0\0\x18"
                            "ftypmp42"sv),
              HasSubstr("video"));
}

TEST(FileFormatTest, TextAndFilesOfPalpateAreNotForeign) {
  for (const std::string_view text :
       {"t,x\n0,1\n"sv, "a,b,ftyp\n1,2,3\n"sv, "name: gel\n"sv, "$MeshFormat\n2.2 0 8\n"sv,
        "solid cube\n"sv, "ply\nformat ascii 1.0\n"sv, "\xEF\xBB\xBFt,x\n"sv, ""sv}) {
    EXPECT_EQ(ForeignFormat(text), "") << text;
  }
  EXPECT_EQ(ForeignFile("/nowhere"), "");
}

}  // namespace
}  // namespace palpate
