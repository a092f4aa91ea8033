#include "slave/tactile/localise/electrode_layout.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::HasSubstr;

// Nineteen rows; electrode i sits at (-i, i / 2, -3) mm.
std::string Rows(int leave_out = 0) {
  std::string text = "# name,x,y,z,nx,ny,nz\nname,x,y,z,nx,ny,nz\n";
  for (int i = kElectrodeCount; i >= 1; --i) {
    if (i == leave_out) continue;
    const std::string number = std::to_string(i);
    text.append("E").append(number).append(", -").append(number).append(",");
    text.append(std::to_string(0.5 * i)).append(",-3,0,0.6,-0.8\r\n");
  }
  return text + "X1,1,2,3,0,0,1\n\n";
}

std::string ComplaintAbout(const std::filesystem::path& file) {
  return Thrown<std::runtime_error>([&] { ReadElectrodeLayout(file); });
}

TEST(ElectrodeLayoutTest, ReadsMillimetresInAnyOrderAndPassesOverOtherNames) {
  const Scratch scratch;
  const ElectrodeLayout layout = ReadElectrodeLayout(scratch.Write("layout.csv", Rows()));
  for (int i = 1; i <= kElectrodeCount; ++i) {
    const auto k = static_cast<std::size_t>(i - 1);
    EXPECT_LT((layout.p_F[k] - Eigen::Vector3d(-1e-3 * i, 0.5e-3 * i, -3e-3)).norm(), 1e-15) << i;
    EXPECT_LT((layout.n_F[k] - Eigen::Vector3d(0, 0.6, -0.8)).norm(), 1e-15) << i;
  }
}

TEST(ElectrodeLayoutTest, SaysWhatIsWrongAndInWhichLine) {
  const Scratch scratch;
  const std::pair<std::string, const char*> rows[] = {
      {Rows(7), "E7 is missing"},
      {Rows() + "E3,1,2,3,0,0,1\n", "layout.csv:24: E3 occurs twice"},
      {"E3,1,2,3,0,0\n", "layout.csv:1: E3,1,2,3,0,0"},
      {"\nE3,1,2,3,0,0,1,5\n", "layout.csv:2: E3"},
      {"E3\n", "expected NAME,x,y,z,nx,ny,nz"},
      {"E3,1,nan,3,0,0,1\n", "layout.csv:1: E3"},
      {"E3,1,2,3e4,0,0,1\n", "farther than 1 m"},
      {"E3,1,2,3,0,0,0\n", "not a unit vector"}};
  for (const auto& [content, words] : rows) {
    EXPECT_THAT(ComplaintAbout(scratch.Write("layout.csv", content)), HasSubstr(words));
  }
  EXPECT_THAT(ComplaintAbout(scratch.path()), HasSubstr("cannot be read"));
}

TEST(ElectrodeLayoutTest, ALayoutInMetresIsRefused) {
  const Scratch scratch;
  const auto complaint = [&](const char* text) {
    return Thrown<std::runtime_error>([&] {
      ReadElectrodeLayout(scratch.Write("layout.csv", text), {2, "kPa"});
    });
  };
  EXPECT_EQ(complaint("c1,0,0,0,0,0,1\nc2,12,0,0,0,0,1\n"), "");
  EXPECT_THAT(complaint("c1,0,0,0,0,0,1\nc2,0.012,0,0,0,0,1\n"),
              HasSubstr("the channels span 0.012 mm, in metres 12 mm: expected millimetres"));
}

// Properties of SimulatedLayout at any size: electrodes separate from each other, under the skin,
// on the pad's side, mirrored about the plane y = 0, normals outward.
TEST(ElectrodeLayoutTest, SimulatedElectrodesAreSpreadUnderTheSkinAtAnySize) {
  for (const double radius : {1e-9, 7e-3, 1e3}) {
    const ElectrodeLayout layout = SimulatedLayout(radius);
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const Eigen::Vector3d p = layout.p_F[i] / radius;
      const Eigen::Vector3d outward(std::max(p.x(), 0.0), p.y(), p.z());
      EXPECT_GT(outward.norm(), 0.5) << i;
      EXPECT_LT(outward.norm(), 0.9) << i;
      EXPECT_LT(p.z(), 0) << i;
      EXPECT_LT((layout.n_F[i] - outward.normalized()).norm(), 1e-12) << i;
      bool has_mirror = false;
      for (std::size_t j = 0; j < kElectrodeCount; ++j) {
        const Eigen::Vector3d q = layout.p_F[j] / radius;
        EXPECT_TRUE(i == j || (p - q).norm() > 0.3) << i << " and " << j;
        has_mirror |= (q - Eigen::Vector3d(p.x(), -p.y(), p.z())).norm() < 1e-12;
      }
      EXPECT_TRUE(has_mirror) << i;
    }
  }
}

}  // namespace
}  // namespace palpate
