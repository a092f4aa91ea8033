// Datagrams that nobody reads or makes but the two ends of a stream, which handed over the keys.
//
//   counter (8 bytes, big endian) | ciphertext | tag (16 bytes)
//
// ChaCha20-Poly1305 (RFC 8439), by OpenSSL. The counter is the nonce: it rises with each datagram,
// and each stream has a key of its own for each way, so that none is used twice.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

using EVP_CIPHER_CTX = struct evp_cipher_ctx_st;

namespace palpate {

// With its seal [bytes]: passes whole wherever IPv6 does (RFC 8200, section 5: 1280 with headers).
inline constexpr std::size_t kLargestDatagram = 1200;
inline constexpr std::size_t kSealSize = 24;

using DatagramKey = std::array<std::uint8_t, 32>;
// Throws std::runtime_error: the system has no random numbers.
DatagramKey NewDatagramKey();
// nullopt: not as many bytes as a key has.
std::optional<DatagramKey> DatagramKeyFrom(std::string_view bytes);

using CipherContext = std::unique_ptr<EVP_CIPHER_CTX, void (*)(EVP_CIPHER_CTX*)>;

// One thread at a time. Allocation-free once made, as is the other end.
class DatagramSealer {
 public:
  // Throws std::runtime_error: OpenSSL lacks the cipher.
  explicit DatagramSealer(const DatagramKey& key);
  // Stands until the next one. Empty: `plain` is, or does not fit.
  std::span<const std::uint8_t> Seal(std::span<const std::uint8_t> plain) noexcept;

 private:
  CipherContext cipher_;
  std::uint64_t counter_ = 0;  // of the last one
  std::array<std::uint8_t, kLargestDatagram> sealed_{};
};

// One thread at a time.
class DatagramOpener {
 public:
  explicit DatagramOpener(const DatagramKey& key);
  // What was sealed under this key later than everything opened before: the newest wins, so that
  // what comes again, or was overtaken, is nothing. Stands until the next one. Empty: it is not.
  std::span<const std::uint8_t> Open(std::span<const std::uint8_t> sealed) noexcept;
  [[nodiscard]] std::uint64_t newest() const noexcept {
    return newest_;
  }  // counter opened; 0: none

 private:
  CipherContext cipher_;
  std::uint64_t newest_ = 0;
  std::array<std::uint8_t, kLargestDatagram> plain_{};
};

}  // namespace palpate
