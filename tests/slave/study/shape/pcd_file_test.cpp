// Reference: the Point Cloud Library's writer and reader.
#include "slave/study/clouds/pcd_file.h"

#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate::study {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class PcdFileTest : public FolderTest {
 protected:
  fs::path Write(const std::string& content) { return FolderTest::Write("cloud.pcd", content); }
  std::string Complaint(const std::string& content) {
    return Thrown<std::invalid_argument>([&] { ReadPcd(Write(content)); });
  }
};

// An organised cloud. Every fifth point is not measured; the data are repetitive, so that they can
// be compressed.
pcl::PointCloud<pcl::PointXYZRGBL> Sample() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  pcl::PointCloud<pcl::PointXYZRGBL> cloud(40, 30);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    auto& p = cloud[i];
    const auto k = static_cast<float>(i % 40);
    p.x = 0.01F * k - 0.2F, p.y = 0.013F * static_cast<float>(i / 40), p.z = 0.9F;
    if (i % 5 == 0) p.x = p.y = p.z = kNan;
    p.r = static_cast<std::uint8_t>(200 + i % 50), p.g = static_cast<std::uint8_t>(i % 7), p.b = 13;
    p.a = 255;
    p.label = static_cast<std::uint32_t>(i % 3) + 70000;
  }
  cloud.is_dense = false;
  return cloud;
}

void ExpectSample(const PcdCloud& read, double tolerance) {
  const auto expected = Sample();
  std::size_t k = 0;
  for (const auto& p : expected) {
    if (!std::isfinite(p.x)) continue;
    ASSERT_LT(k, read.cloud->size());
    const auto& q = (*read.cloud)[k++];
    ASSERT_NEAR((q.getVector3fMap() - p.getVector3fMap()).norm(), 0, tolerance);
    ASSERT_EQ(q.getRGBVector3i(), p.getRGBVector3i());
    ASSERT_EQ(q.label, p.label);
  }
  EXPECT_EQ(k, read.cloud->size());
  EXPECT_EQ(read.dropped, expected.size() - k);
}

TEST_F(PcdFileTest, AllThreeFormsReadAsThePointCloudLibraryWroteThem) {
  const fs::path file = folder_ / "form.pcd";
  const auto cloud = Sample();
  pcl::PCDWriter writer;
  writer.writeBinary(file.string(), cloud);
  ExpectSample(ReadPcd(file), 0);
  writer.writeBinaryCompressed(file.string(), cloud);
  // The file is compressed, so repeated data is tested.
  EXPECT_LT(fs::file_size(file), 8 * cloud.size());
  ExpectSample(ReadPcd(file), 0);
  writer.writeASCII(file.string(), cloud, 8);
  ExpectSample(ReadPcd(file), 1e-7);  // eight digits
}

std::string Header(const std::string& data, const std::string& count = "2") {
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + count +
         "\nHEIGHT 1\nPOINTS " + count + "\nDATA " + data + "\n";
}

TEST_F(PcdFileTest, WhatIsWrittenIsRead) {
  const fs::path file = folder_ / "ours.pcd";
  PointCloud cloud = *ReadPcd(Write(Header("ascii") + "1 2 3\n4 5 6\n")).cloud;
  cloud[1].r = 250, cloud[1].b = 9, cloud[0].label = 7;
  ASSERT_TRUE(WritePcd(file, cloud));
  const PointCloud read = *ReadPcd(file).cloud;
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].getVector3fMap(), Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(read[1].getRGBVector3i(), Eigen::Vector3i(250, 0, 9));
  EXPECT_EQ(read[0].label, 7U);
  EXPECT_FALSE(WritePcd(folder_ / "no" / "such" / "folder.pcd", cloud));
}

TEST_F(PcdFileTest, FarthestAndInfinitePointsAreDropped) {
  const PcdCloud read =
      ReadPcd(Write(Header("ascii", "5") + "1 2 3\n1 2 4\n1 2 501\n1e999 0 0\ninf 0 0"));
  EXPECT_EQ(read.cloud->size(), 2U);
  EXPECT_EQ(read.dropped, 3U);
}

TEST_F(PcdFileTest, ComplaintsNameTheFileAndWhatIsExpected) {
  EXPECT_THAT(Complaint(""), HasSubstr("cloud.pcd: no PCD header"));
  EXPECT_THAT(Complaint("\x89PNG\r\n\x1a\n...."), HasSubstr("is a PNG image"));
  EXPECT_THAT(Complaint("VERSION 0.7\nFIELDS x y z\n"), HasSubstr("no PCD header"));
  EXPECT_THAT(Complaint(Header("ascii") + "1 2 3\n     \n"), HasSubstr("cut off"));
  EXPECT_THAT(Complaint(Header("binary") + "12345678"), HasSubstr("cut off: expected 2 points"));
  for (const char* form : {"ascii", "binary"}) {
    EXPECT_THAT(Complaint(Header(form, "0")), HasSubstr("cloud.pcd: no finite point"));
  }
  EXPECT_THAT(Complaint(Header("ascii", "1") + "nan nan nan\n"), HasSubstr("no finite point"));
  EXPECT_THAT(Complaint(Header("ascii") + "1 2 300\n1 2 400\n"), HasSubstr("the units look wrong"));
  EXPECT_THAT(Complaint("FIELDS x y z\nSIZE 4 4 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
                        "POINTS 1\nDATA ascii\n1 2 3\n"),
              HasSubstr("field z: expected TYPE F and SIZE 4"));
  EXPECT_THAT(Complaint("FIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 1\n"
                        "HEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3 4\n"),
              HasSubstr("field label: expected TYPE U and SIZE 4"));
  EXPECT_THAT(Complaint("FIELDS x y w\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
                        "POINTS 1\nDATA ascii\n1 2 3\n"),
              HasSubstr("x, y and z"));
  EXPECT_THAT(Thrown<std::invalid_argument>([&] { ReadPcd(folder_ / "none.pcd"); }),
              HasSubstr("none.pcd: there is no such file"));
  for (const char* form : {"binary", "ascii", "binary_compressed"}) {  // before any is reserved
    EXPECT_NE(Complaint(Header(form, "4294967295") + std::string(8, '1')), "") << form;
  }
}

// Reference: none is needed; every damaged file is either refused or makes finite points.
TEST_F(PcdFileTest, DamagedFilesAreRefusedOrReadNeverWorse) {
  std::mt19937 generator(4);
  const fs::path file = folder_ / "whole.pcd";
  pcl::PCDWriter writer;
  int refused = 0;
  for (int form = 0; form < 3; ++form) {
    if (form == 0) writer.writeBinary(file.string(), Sample());
    if (form == 1) writer.writeBinaryCompressed(file.string(), Sample());
    if (form == 2) writer.writeASCII(file.string(), Sample());
    const std::string whole = Read(file);
    for (int i = 0; i < 30; ++i) {
      std::string damaged = whole;
      std::uniform_int_distribution<std::size_t> place(0, whole.size() - 1);
      if (i % 3 == 0) {
        damaged.resize(place(generator));
      } else {
        for (int k = 0; k < 3; ++k) {
          damaged[place(generator) % (i % 3 == 1 ? 250 : whole.size())] =
              static_cast<char>(generator());
        }
      }
      try {
        const PcdCloud read = ReadPcd(Write(damaged));
        for (const auto& p : *read.cloud) ASSERT_TRUE(p.getVector3fMap().allFinite());
      } catch (const std::invalid_argument&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 30);  // at least those cut off
}

}  // namespace
}  // namespace palpate::study
