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
  EXPECT_THAT(ForeignFormat("TDSm\x0e\0\0\0"sv), AllOf(HasSubstr("LabVIEW"), HasSubstr("CSV")));
}

TEST(FileFormatTest, MeshesOfOtherProgramsAreNamedWithTheWayToConvertThem) {
  for (const std::string_view deck :
       {"*HEADING\n*NODE\n"sv, "*Node\n1, 0, 0, 0\n"sv, "** Job-1\n*Heading\n"sv}) {
    EXPECT_THAT(ForeignFormat(deck), AllOf(HasSubstr("Abaqus"), HasSubstr("meshio"))) << deck;
  }
  EXPECT_THAT(ForeignFormat("$ a deck\nSOL 101\nCEND\nBEGIN BULK\n"), HasSubstr("Nastran"));
  EXPECT_THAT(ForeignFormat("# Blender\no Cube\nv 0 0 1\n"), HasSubstr("Wavefront"));
  EXPECT_THAT(ForeignFormat("mtllib cube.mtl\no Cube\n"), HasSubstr("Wavefront"));
  EXPECT_THAT(ForeignFormat("OFF\n4 4 6\n"), HasSubstr("Geomview"));
  EXPECT_THAT(ForeignFormat("glTF\2\0\0\0"sv), HasSubstr("STL"));
  EXPECT_THAT(ForeignFormat("ISO-10303-21;\nHEADER;\n"),
              AllOf(HasSubstr("CAD"), HasSubstr("gmsh")));
  EXPECT_THAT(ForeignFormat("<mujoco model=\"gel\">\n"), HasSubstr("XML"));
}

TEST(FileFormatTest, TextAndFilesOfPalpateAreNotForeign) {
  for (const std::string_view text :
       {"t,x\n0,1\n"sv, "a,b,ftyp\n1,2,3\n"sv, "name: gel\n"sv, "$MeshFormat\n2.2 0 8\n"sv,
        "solid cube\n"sv, "ply\nformat ascii 1.0\n"sv, "v 1,x\n0,1\n"sv, "** remark\nt,x\n"sv,
        "# a\n8 3 0 0\n1 0 0 0\n"sv, "{\"name\": \"gel\"}"sv, "\xEF\xBB\xBFt,x\n"sv, ""sv}) {
    EXPECT_EQ(ForeignFormat(text), "") << text;
  }
  EXPECT_EQ(ForeignFile("/nowhere"), "");
}

}  // namespace
}  // namespace palpate
