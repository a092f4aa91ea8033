#include "slave/mechanics/fem/green/column_cache.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::uint64_t kMagic = 0x31306e6565726770;  // also shows the byte order

struct Header {
  std::uint64_t magic = kMagic;
  std::uint64_t hash = 0;
  std::uint64_t number = 0;
  std::uint64_t count = 0;
  std::uint64_t checksum = 0;
};

std::uint64_t Checksum(std::span<const double> values) {
  return Hash().Add(std::as_bytes(values)).value();
}

}  // namespace

Hash& Hash::Add(std::span<const std::byte> bytes) {
  constexpr std::uint64_t kPrime = 0x100000001b3;
  for (std::size_t i = 0; i < bytes.size(); i += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min(sizeof word, bytes.size() - i));
    value_ = (value_ ^ word) * kPrime;
    value_ ^= value_ >> 29U;  // mixes high bits into low ones
  }
  return *this;
}

ColumnCache::ColumnCache(const std::filesystem::path& folder, std::uint64_t hash) : hash_(hash) {
  if (folder.empty()) return;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(hash));
  folder_ = folder / (std::string("fem-green-") + digits.data());
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
}

bool ColumnCache::Has(int number) const {
  std::error_code ignored;
  return enabled() && std::filesystem::exists(FileOf(number), ignored);
}

bool ColumnCache::Load(int number, std::span<double> values) const {
  if (!enabled()) return false;
  std::ifstream in(FileOf(number), std::ios::binary);
  Header header;
  const auto bytes = static_cast<std::streamsize>(values.size_bytes());
  if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
  if (header.magic != kMagic || header.hash != hash_ ||
      header.number != static_cast<std::uint64_t>(number) || header.count != values.size()) {
    return false;
  }
  if (!in.read(reinterpret_cast<char*>(values.data()), bytes)) return false;
  return header.checksum == Checksum(values);
}

void ColumnCache::Save(int number, std::span<const double> values) const {
  if (!enabled()) return;
  const Header header{.hash = hash_,
                      .number = static_cast<std::uint64_t>(number),
                      .count = values.size(),
                      .checksum = Checksum(values)};
  const auto write = [&](std::FILE* file) {
    return std::fwrite(&header, sizeof header, 1, file) == 1 &&
           std::fwrite(values.data(), sizeof(double), values.size(), file) == values.size();
  };
  // If it fails, the block is computed again.
  static_cast<void>(TryReplace(FileOf(number), write, Links::kReplace));
}

void ColumnCache::Keep(int number, std::span<const double> values) const {
  Save(number, values);
  if (!Has(number)) throw std::runtime_error("cannot write to the cache " + folder_.string());
}

}  // namespace palpate
