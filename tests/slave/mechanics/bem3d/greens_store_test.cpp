#include "slave/mechanics/bem3d/greens_store.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/bem3d/surface_greens.h"
#include "tests/slave/mechanics/bem3d/solid_bodies.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

class GreensStoreTest : public FolderTest {
 protected:
  [[nodiscard]] SurfaceGreens Make(double nu = 0.3, Progress* progress = nullptr) const {
    const SurfaceMesh mesh = solid_bodies::Box({1, 1, 1}, {3, 3, 3});
    const auto bottom = [](const Eigen::Vector3d& p) { return p.z() < 1e-9; };
    return {mesh, solid_bodies::HeldWhere(mesh, bottom), nu, {.cache = folder_}, progress};
  }
  [[nodiscard]] std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    if (!fs::exists(folder_)) return files;
    for (const auto& entry : fs::directory_iterator(folder_)) files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
  }
};

std::vector<double> Numbers(const SurfaceGreens& greens) {
  const double* first = greens.column(0);
  std::vector<double> numbers(first, greens.column(greens.places()));
  for (int j = 0; j < greens.places(); ++j) {
    for (int i = 0; i < greens.places(); ++i) {
      const auto reaction = greens.Reaction(i, j, Eigen::Vector3d(1, 2, 3));
      numbers.insert(numbers.end(), reaction.begin(), reaction.end());
    }
  }
  numbers.push_back(greens.condition());
  return numbers;
}

void FlipByte(const fs::path& path, std::uintmax_t at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(at));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(at));
  file.put(static_cast<char>(byte ^ 0x10));
}

// Reference: the computation itself, bit for bit.
TEST_F(GreensStoreTest, WhatIsReadIsWhatWasComputed) {
  const auto computed = Make();
  ASSERT_EQ(Files().size(), 1U);
  EXPECT_EQ(Files()[0].extension(), ".greens");
  const auto read = Make();
  EXPECT_FALSE(computed.from_cache());
  EXPECT_TRUE(read.from_cache());
  EXPECT_EQ(Numbers(read), Numbers(computed));
}

TEST_F(GreensStoreTest, AnotherPoissonRatioIsAnotherFile) {
  const auto one = Make(0.3);
  const auto other = Make(0.31);
  EXPECT_FALSE(other.from_cache());
  EXPECT_EQ(Files().size(), 2U);
  EXPECT_NE(Numbers(one), Numbers(other));
}

// A changed bit anywhere: in heads, inputs or numbers.
TEST_F(GreensStoreTest, DamagedFilesAreIgnoredAndWrittenAnew) {
  const auto computed = Make();
  const auto size = fs::file_size(Files()[0]);
  for (const std::uintmax_t at :
       {std::uintmax_t{0}, std::uintmax_t{20}, std::uintmax_t{200}, size / 2, size - 3}) {
    FlipByte(Files()[0], at);
    const auto again = Make();
    EXPECT_FALSE(again.from_cache()) << "byte " << at;
    EXPECT_EQ(Numbers(again), Numbers(computed)) << "byte " << at;
    EXPECT_TRUE(Make().from_cache()) << "byte " << at;
  }
}

TEST_F(GreensStoreTest, ShortLongAndForeignFilesAreIgnoredAndWrittenAnew) {
  const auto computed = Make();
  const auto path = Files()[0];
  const auto size = fs::file_size(path);
  for (const std::uintmax_t other :
       {std::uintmax_t{0}, std::uintmax_t{31}, size / 2, size - 1, size + 8}) {
    fs::resize_file(path, other);
    const auto again = Make();
    EXPECT_FALSE(again.from_cache()) << other << " bytes";
    EXPECT_EQ(Numbers(again), Numbers(computed)) << other << " bytes";
  }
  std::ofstream(path) << "something else altogether, and long enough to hold a head of a section";
  EXPECT_FALSE(Make().from_cache());
  EXPECT_TRUE(Make().from_cache());
}

// Stops when a stage has come so far.
class StopAt final : public Progress {
 public:
  StopAt(std::string stage, double done) : stage_(std::move(stage)), done_(done) {}
  void Expect(const PrecomputeCost& cost) override { cost_ = cost; }
  bool Report(std::string_view stage, double done) override {
    seen_.emplace_back(stage);
    return stage != stage_ || done < done_;
  }
  [[nodiscard]] const PrecomputeCost& cost() const { return cost_; }
  [[nodiscard]] long count(std::string_view stage) const {
    return std::ranges::count(seen_, stage);
  }

 private:
  std::string stage_;
  double done_;
  PrecomputeCost cost_;
  std::vector<std::string> seen_;
};

// Reference: the computation that was not interrupted, bit for bit.
TEST_F(GreensStoreTest, InterruptedComputationsAreTakenUp) {
  const auto whole = Numbers(Make());
  fs::remove_all(folder_);
  for (const auto& [stage, done] :
       {std::pair{"integrals", 0.3}, {"factorisation", 0.5}, {"green's functions", 0.5}}) {
    StopAt stop(stage, done);
    EXPECT_THROW((void)Make(0.3, &stop), Interrupted) << stage;
  }
  ASSERT_EQ(Files().size(), 1U);
  EXPECT_EQ(Files()[0].extension(), ".partial");
  const auto resumed = Make();
  EXPECT_FALSE(resumed.from_cache());
  EXPECT_EQ(Numbers(resumed), whole);
  ASSERT_EQ(Files().size(), 1U);
  EXPECT_EQ(Files()[0].extension(), ".greens");
}

// Reference as above; the damage may lie anywhere in what was kept.
TEST_F(GreensStoreTest, DamagedPartsAreComputedAnew) {
  const auto whole = Numbers(Make());
  fs::remove_all(folder_);
  for (const double where : {0.0, 0.05, 0.4, 0.8, 0.999}) {
    StopAt stop("green's functions", 0.9);
    EXPECT_THROW((void)Make(0.3, &stop), Interrupted);
    const auto partial = Files()[0];
    FlipByte(partial,
             static_cast<std::uintmax_t>(where * static_cast<double>(fs::file_size(partial))));
    EXPECT_EQ(Numbers(Make()), whole) << "damaged at " << where;
    fs::remove_all(folder_);
  }
}

TEST_F(GreensStoreTest, TellWhatToExpect) {
  StopAt never("", 0);
  const auto greens = Make(0.3, &never);
  EXPECT_GT(never.cost().seconds, 0);
  EXPECT_LT(never.cost().seconds, 60);
  EXPECT_GE(never.cost().memory_bytes, greens.memory_bytes());
  EXPECT_GT(never.count("integrals"), 1);
  EXPECT_GT(never.count("factorisation"), 1);
  EXPECT_GT(never.count("green's functions"), 1);
}

// A file where the folder should be: nothing can be kept, and the answer does not suffer.
TEST_F(GreensStoreTest, FoldersThatCannotBeWrittenToCostOnlyTheFile) {
  fs::remove(folder_);
  std::ofstream(folder_) << "in the way";
  const auto greens = Make();
  EXPECT_FALSE(greens.from_cache());
  EXPECT_NE(greens.remark().find("cannot write to the cache"), std::string::npos);
}

TEST_F(GreensStoreTest, LinksAreNotFollowed) {
  const GreensData data{{1, 2}, {3}, 4};
  GreensStore(folder_, {1}).Finish(data);
  const auto result = Files()[0], target = folder_ / "target";
  fs::remove(result);
  std::ofstream(target) << "mine";
  for (const fs::path& name : {fs::path(result.string() + ".new"), result}) {
    fs::create_symlink(target, name);
    GreensStore(folder_, {1}).Finish(data);
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(result)));
    EXPECT_TRUE(GreensStore(folder_, {1}).Load());
    EXPECT_EQ(fs::file_size(target), 4U);
    fs::remove(result);
  }
  fs::create_symlink(target, fs::path(result).replace_extension(".partial"));
  GreensStore store(folder_, {1});
  store.Keep(GreensStore::Part::kFactor, 0, data.blocks);
  EXPECT_NE(store.remark().find("cannot write to the cache"), std::string::npos);
  EXPECT_EQ(fs::file_size(target), 4U);
}

TEST_F(GreensStoreTest, OnlyOneOfTwoKeepsTheSame) {
  GreensStore one(folder_, {1, 2, 3});
  GreensStore other(folder_, {1, 2, 3});
  const std::vector<double> part{4, 5};
  one.Keep(GreensStore::Part::kFactor, 0, part);
  other.Keep(GreensStore::Part::kFactor, 0, part);
  EXPECT_EQ(one.remark(), "");
  EXPECT_EQ(other.remark(), "another process computes the same functions");
}

}  // namespace
}  // namespace palpate
