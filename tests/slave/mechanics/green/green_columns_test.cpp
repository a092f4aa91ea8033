#include "slave/mechanics/fem/green/green_columns.h"

#include <cstring>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "slave/mechanics/fem/green/fem_green_model.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/direct_solution.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Element = FemOptions::Element;

constexpr std::size_t kPlenty = std::size_t{1} << 30;

GreenColumns ColumnsOf(const Body& body, const fs::path& cache = {}, std::size_t limit = kPlenty,
                       Element element = Element::kTet4) {
  return {AssembleAtRest(body.mesh, body.held, body.nu, element), limit, cache, nullptr};
}

bool SameBits(GreenColumns& a, GreenColumns& b, int place) {
  return std::memcmp(a.Column(place), b.Column(place), a.bytes_per_place()) == 0;
}

// The files in it.
std::vector<fs::path> Files(const Scratch& scratch) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(scratch.path())) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

// The order of the queries does not change any digit.
TEST(GreenColumns, LazyIsEagerBitForBit) {
  const Body body = ShakenBox({4, 4, 3}, 1, 0.3);
  GreenColumns eager = ColumnsOf(body), lazy = ColumnsOf(body);
  std::vector<int> all;
  for (int p = 0; p < eager.places(); ++p) all.push_back(p);
  ASSERT_TRUE(eager.Prefetch(all, nullptr));
  for (int k = 0; k < 2 * lazy.places(); ++k) {
    const int place = k * 37 % lazy.places();
    ASSERT_TRUE(SameBits(lazy, eager, place)) << place;
  }
}

TEST(GreenColumns, ComeFromTheCacheBitForBitAndOnlyForTheSameProblem) {
  const Body body = ShakenBox({4, 3, 3}, 1, 0.3);
  const Scratch scratch;
  GreenColumns first = ColumnsOf(body, scratch.path());
  const int top = first.places() - 1;  // the last corner of the curve is free
  ASSERT_NE(first.Column(top), nullptr);
  ASSERT_NE(first.Column(20), nullptr);
  EXPECT_EQ(first.groups_computed(), 2);
  GreenColumns second = ColumnsOf(body, scratch.path());
  EXPECT_TRUE(SameBits(first, second, top));
  EXPECT_TRUE(SameBits(first, second, 20));
  EXPECT_EQ(second.groups_computed(), 0);
  Body other = body;
  other.nu = 0.31;
  GreenColumns by_nu = ColumnsOf(other, scratch.path());
  EXPECT_FALSE(SameBits(first, by_nu, top));
  other = body;
  other.held[30] = {true, true, true};
  GreenColumns by_support = ColumnsOf(other, scratch.path());
  EXPECT_FALSE(SameBits(first, by_support, top));
  other = body;
  other.mesh.nodes[40].x() += 1e-5;
  GreenColumns by_mesh = ColumnsOf(other, scratch.path());
  EXPECT_FALSE(SameBits(first, by_mesh, top));
  EXPECT_EQ(by_nu.groups_computed() + by_support.groups_computed() + by_mesh.groups_computed(), 3);
}

TEST(GreenColumns, ComeFromTheCacheOnlyForTheSameElements) {
  const Scratch scratch;
  std::vector<double> corner;
  for (const Element element : {Element::kTet4, Element::kTet10}) {
    for (const double nu : {0.489, 0.49, 0.499}) {  // with pressure from 0.49 on
      GreenColumns columns =
          ColumnsOf(ShakenBox({3, 3, 2}, 1, nu), scratch.path(), kPlenty, element);
      const int place = columns.places() - 1;
      corner.push_back(columns.Column(place)[9 * place]);
      EXPECT_EQ(columns.groups_computed(), 1);
    }
  }
  std::ranges::sort(corner);
  EXPECT_EQ(std::ranges::adjacent_find(corner), corner.end());
}

TEST(ColumnCacheTest, LinksAreNotFollowed) {
  const Scratch scratch;
  const ColumnCache cache(scratch.path(), 1);
  const std::vector<double> values{1, 2};
  cache.Save(0, values);
  const auto file = Files(scratch).at(0), target = scratch.path() / "target";
  std::ofstream(target) << "mine";
  for (const fs::path& name : {fs::path(file.string() + "." + std::to_string(::getpid())), file}) {
    fs::remove(file);
    fs::create_symlink(target, name);
    cache.Save(0, values);
    std::vector<double> loaded(2);
    EXPECT_TRUE(cache.Load(0, loaded));
    EXPECT_EQ(loaded, values);
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(file)));
    EXPECT_EQ(fs::file_size(target), 4U);
  }
}

// Shortened, overwritten, emptied, of another number: each is computed again, and mended on disk.
TEST(GreenColumns, ATornCacheIsNoticed) {
  const Body body = ShakenBox({3, 3, 2}, 1, 0.3);
  GreenColumns clean = ColumnsOf(body);
  const int last = clean.places() - 1;
  for (int damage = 0; damage < 5; ++damage) {
    const Scratch scratch;
    GreenColumns writer = ColumnsOf(body, scratch.path());
    std::vector<int> all;
    for (int p = 0; p <= last; ++p) all.push_back(p);
    ASSERT_TRUE(writer.Prefetch(all, nullptr));
    const auto files = Files(scratch);
    ASSERT_GE(files.size(), 3U);
    const auto bytes = fs::file_size(files[0]);
    std::fstream file(files[0], std::ios::binary | std::ios::in | std::ios::out);
    if (damage == 0) fs::resize_file(files[0], bytes - 8);
    if (damage == 1) fs::resize_file(files[0], 0);
    if (damage == 2) file.seekp(static_cast<long>(bytes / 2)).put('\x55').flush();
    if (damage == 3) fs::copy_file(files[1], files[0], fs::copy_options::overwrite_existing);
    if (damage == 4) file.seekp(0).put('\x55').flush();
    file.close();
    GreenColumns reader = ColumnsOf(body, scratch.path());
    for (int p = 0; p <= last; ++p) ASSERT_TRUE(SameBits(reader, clean, p)) << damage;
    EXPECT_EQ(reader.groups_computed(), 1) << damage;
    GreenColumns again = ColumnsOf(body, scratch.path());
    for (int p = 0; p <= last; ++p) again.Column(p);
    EXPECT_EQ(again.groups_computed(), 0) << damage;
  }
}

TEST(GreenColumns, AFolderThatCannotBeWrittenCausesNoError) {
  const Body body = ShakenBox({2, 2, 2}, 1, 0.3);
  GreenColumns columns = ColumnsOf(body, "/proc/no/such/folder");
  GreenColumns clean = ColumnsOf(body);
  EXPECT_TRUE(SameBits(columns, clean, 3));
}

TEST(GreenColumns, ReportsExpectedCostAndStopsBeforeTheFactor) {
  struct Stop final : Progress {
    void Expect(const PrecomputeCost& cost) override { expected = cost; }
    bool Report(std::string_view /*stage*/, double /*done*/) override { return false; }
    PrecomputeCost expected;
  };
  const Body body = ShakenBox({3, 3, 3}, 1, 0.3);
  Stop stop;
  EXPECT_THROW(FemGreenModel(body.mesh, body.held, 1, 0.3, {}, &stop), Interrupted);
  EXPECT_GT(stop.expected.seconds, 0);
  EXPECT_GT(stop.expected.memory_bytes, 0U);
}

TEST(GreenColumns, TheMemoryLimitIsKeptAndReported) {
  const Body body = ShakenBox({4, 4, 3}, 1, 0.3);
  FemGreenModel probe(body.mesh, body.held, 1, 0.3, {});
  const std::size_t group = GreenColumns::kGroup * probe.columns().bytes_per_place();
  FemGreenModel model(body.mesh, body.held, 1, 0.3, {.memory_limit = 3 * group + group / 2});
  std::vector<int> all;
  for (int p = 0; p < model.columns().places(); ++p) all.push_back(p);
  EXPECT_FALSE(model.columns().Prefetch(all, nullptr));
  int ready = 0;
  for (int p = 0; p < model.columns().places(); ++p) ready += model.columns().IsReady(p) ? 1 : 0;
  EXPECT_GE(ready, 3 * GreenColumns::kGroup);
  EXPECT_LT(ready, 4 * GreenColumns::kGroup);  // the last group may be a small one
  bool reported = false;
  for (int p = 0; p < model.columns().places(); ++p) {
    const int node = model.columns().node_of_place()[static_cast<std::size_t>(p)];
    if (model.columns().IsReady(p) || body.held[static_cast<std::size_t>(node)][0]) continue;
    const Vector3d& p_O = body.mesh.nodes[static_cast<std::size_t>(node)];
    EXPECT_EQ(contacts::Answer(model, contacts::Move(p_O, {0, 0, 0})).validity, Validity::kFailed);
    reported = model.failure().find("memory") != std::string_view::npos;
  }
  EXPECT_TRUE(reported);
}

}  // namespace
}  // namespace palpate
