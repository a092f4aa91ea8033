// Connected regions of a two-valued picture, from the runs of its rows.
#pragma once

#include <cstdint>
#include <vector>

namespace palpate {

// One region's sums over its pixels, and its bounding box (last row and column included).
struct Blob {
  std::int64_t area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  int left = 0, right = 0, top = 0, bottom = 0;
};

// Which of a row's pixels are darker than their tile's threshold: bit x of the words. `thresholds`:
// one per 16 pixels. `bits`: (width + 63) / 64 words; those beyond the row are zero.
void DarkBits(const std::uint8_t* row, int width, const std::uint8_t* thresholds,
              std::uint64_t* bits) noexcept;

// Rows are given from top to bottom; pixels that share an edge belong together.
class BlobLabeller {
 public:
  // In a picture that is all speckles, regions that begin after so many are left out.
  static constexpr std::size_t kMaxRegions = 1 << 15;

  // Allocates only when the width grows.
  void Begin(int width);
  // `bits` as from DarkBits; `inverted`: the zeros are meant.
  void AddRow(int y, const std::uint64_t* bits, bool inverted) noexcept;
  // Every region once, in no order; valid until the next Begin.
  const std::vector<Blob>& Finish() noexcept;
  [[nodiscard]] bool overrun() const { return overrun_; }

 private:
  struct Run {
    int begin, end, label;
  };
  void AddRun(int y, int begin, int end) noexcept;
  int Root(int label) noexcept;
  int Join(int a, int b) noexcept;

  int width_ = 0;
  std::vector<Run> above_, here_;
  std::size_t next_above_ = 0;
  std::vector<int> parents_;  // per label
  std::vector<Blob> blobs_;   // per label; joined ones are empty
  bool overrun_ = false;
};

}  // namespace palpate
