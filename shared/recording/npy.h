// Writes NumPy arrays: numpy.load("force.npy") (format 1.0: numpy.org/doc/stable/reference/
// generated/numpy.lib.format.html).
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

namespace palpate {

template <typename T>
concept NpyNumber = std::same_as<T, double> || std::same_as<T, std::int64_t> ||
    std::same_as<T, std::uint64_t> || std::same_as<T, std::uint8_t>;

// Rows of `columns` numbers. The row count is written at the end.
class NpyFile {
 public:
  // `columns` 1: a vector. Throws std::runtime_error if it cannot write.
  template <NpyNumber T>
  static NpyFile Of(const std::filesystem::path& file, int columns) {
    return {file, TypeOf<T>(), columns};
  }
  NpyFile(NpyFile&&) = default;
  NpyFile& operator=(NpyFile&&) = delete;

  // Adds one row of `columns` numbers of the type of the file.
  template <NpyNumber T>
  void Add(std::span<const T> row) {
    stream_.write(reinterpret_cast<const char*>(row.data()),
                  static_cast<std::streamsize>(row.size_bytes()));
    ++rows_;
  }
  template <NpyNumber T>
  void Add(T value) {
    Add(std::span<const T>(&value, 1));
  }
  // Throws std::runtime_error if a write failed.
  void Finish();

 private:
  NpyFile(std::filesystem::path file, std::string_view type, int columns);
  template <NpyNumber T>
  static std::string_view TypeOf() {
    if constexpr (std::same_as<T, double>) return "<f8";
    if constexpr (std::same_as<T, std::int64_t>) return "<i8";
    if constexpr (std::same_as<T, std::uint64_t>) return "<u8";
    return "|u1";
  }
  void WriteHeader();

  std::filesystem::path file_;
  std::ofstream stream_;
  std::string type_;
  int columns_;
  std::uint64_t rows_ = 0;
};

}  // namespace palpate
