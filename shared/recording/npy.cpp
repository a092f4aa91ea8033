#include "shared/recording/npy.h"

#include <stdexcept>
#include <utility>

namespace palpate {
namespace {

constexpr std::size_t kHeader = 128;  // with magic and length: data begins at a multiple of 64
constexpr std::string_view kMagic{"\x93NUMPY\x01\x00", 8};

}  // namespace

NpyFile::NpyFile(std::filesystem::path file, std::string_view type, int columns)
    : file_(std::move(file)),
      stream_(file_, std::ios::binary | std::ios::trunc),
      type_(type),
      columns_(columns) {
  WriteHeader();
  if (!stream_) throw std::runtime_error(file_.string() + ": cannot be written");
}

void NpyFile::WriteHeader() {
  std::string shape = "(" + std::to_string(rows_) + ",";
  if (columns_ > 1) shape += " " + std::to_string(columns_);
  std::string text =
      "{'descr': '" + type_ + "', 'fortran_order': False, 'shape': " + shape + "), }";
  text.resize(kHeader - kMagic.size() - 3, ' ');
  const auto length = static_cast<std::uint16_t>(text.size() + 1);
  stream_ << kMagic << static_cast<char>(length & 0xff) << static_cast<char>(length >> 8) << text
          << '\n';
}

void NpyFile::Finish() {
  stream_.seekp(0);
  WriteHeader();
  stream_.flush();
  if (!stream_) throw std::runtime_error(file_.string() + ": cannot be written");
}

}  // namespace palpate
