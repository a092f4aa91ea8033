// A temporary folder for one test, removed afterwards.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/paths.h"

namespace palpate {

class Scratch {
 public:
  Scratch() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    static int made = 0;  // a test may have several
    std::string name = std::string(test->test_suite_name()) + "." + test->name() + "." +
                       std::to_string(getpid()) + "." + std::to_string(++made);
    std::replace(name.begin(), name.end(), '/', '.');
    path_ = std::filesystem::path(BinaryPath()) / "test-output" / name;
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::filesystem::path& name) const {
    return path_ / name;
  }
  // Writes `content` as it is.
  std::filesystem::path Write(const std::string& name, const std::string& content) const {
    std::filesystem::remove(path_ / name);  // some file systems wait for a file that is truncated
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }
  static std::string Read(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::filesystem::path path_;
};

// Tests that each have one.
class FolderTest : public testing::Test {
 protected:
  std::filesystem::path Write(const std::string& name, const std::string& content) const {
    return scratch_.Write(name, content);
  }
  static std::string Read(const std::filesystem::path& file) { return Scratch::Read(file); }

 private:
  const Scratch scratch_;

 protected:
  const std::filesystem::path folder_ = scratch_.path();
};

}  // namespace palpate
