// Stores blocks of numbers on disk, identified by a hash of all inputs they depend on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace palpate {

// FNV-1a hash with 64 bits over whole words. Calls of Add can be chained.
class Hash {
 public:
  Hash& Add(std::span<const std::byte> bytes);
  template <typename T>
  Hash& Add(const T& value) {
    return Add(std::as_bytes(std::span(&value, 1)));
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

// One file per block, FOLDER/NAME-HASH/NUMBER.col: written under another name and renamed, so that
// interrupted work leaves complete blocks. Files that are short, damaged, of another machine or
// another problem count as absent. If the folder cannot be written, nothing is stored.
class ColumnCache {
 public:
  // Without a folder it stores and finds no data.
  ColumnCache() = default;
  ColumnCache(const std::filesystem::path& folder, std::uint64_t hash);

  [[nodiscard]] bool Load(int number, std::span<double> values) const;
  // Returns whether the file exists; only Load checks its contents.
  [[nodiscard]] bool Has(int number) const;
  void Save(int number, std::span<const double> values) const;
  // As Save, but throws std::runtime_error if the folder cannot be written.
  void Keep(int number, std::span<const double> values) const;
  [[nodiscard]] bool enabled() const { return !folder_.empty(); }

 private:
  [[nodiscard]] std::filesystem::path FileOf(int number) const {
    return folder_ / (std::to_string(number) + ".col");
  }

  std::filesystem::path folder_;
  std::uint64_t hash_ = 0;
};

struct CacheFilling {
  std::size_t groups = 0, computed = 0;  // groups of the cache, and those computed now
};

}  // namespace palpate
