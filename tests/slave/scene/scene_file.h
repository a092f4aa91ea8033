// A folder for one test's scene files.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace palpate {

// Removed with everything in it when the test ends.
class SceneFolder {
 public:
  SceneFolder() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + "." + test->name();
    for (char& c : name) {
      if (c == '/') c = '.';
    }
    folder_ = std::filesystem::path(::testing::TempDir()) / ("palpate." + name);
    std::filesystem::create_directories(folder_);
  }
  ~SceneFolder() { std::filesystem::remove_all(folder_); }
  SceneFolder(const SceneFolder&) = delete;
  SceneFolder& operator=(const SceneFolder&) = delete;

  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    const auto file = folder_ / name;
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

// A scene of one thing per line, so that tests can replace or add a line and know its number.
inline std::string SmallScene() {
  return "name: small\n"                                                              // 1
         "object:\n"                                                                  // 2
         "  geometry: {rectangle: {width: 80 mm, height: 40 mm, thickness: 9 mm}}\n"  // 3
         "  material: {young_modulus: 127 kPa, poisson_ratio: 0.49}\n"                // 4
         "  fixed: {side: bottom}\n"                                                  // 5
         "model: {kind: bem2d}\n"                                                     // 6
         "tool: {shape: flat, width: 5.87 mm}\n"                                      // 7
         "sense:\n"                                                                   // 8
         "  camera: {source: simulated, pixel: 0.35 mm}\n"                            // 9
         "  tip: {track: template}\n"                                                 // 10
         "  contour: {track: snake}\n";                                               // 11
}

// SmallScene with line `line` (from 1) replaced.
inline std::string SmallSceneWith(int line, const std::string& replacement) {
  std::string text = SmallScene();
  std::size_t begin = 0;
  for (int i = 1; i < line; ++i) begin = text.find('\n', begin) + 1;
  return text.replace(begin, text.find('\n', begin) - begin, replacement);
}

}  // namespace palpate
