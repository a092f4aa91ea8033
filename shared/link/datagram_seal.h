// Authenticated encryption of datagrams. The two ends exchange the keys over the stream.
//
//   counter (8 bytes, big endian) | ciphertext | tag (16 bytes)
//
// ChaCha20-Poly1305 (RFC 8439), by OpenSSL. The counter is the nonce. It rises with each datagram,
// and each stream has a separate key per direction, so that no nonce is used twice.
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

// Including the seal [bytes]. Fits the minimum IPv6 MTU (RFC 8200, section 5: 1280 with headers).
inline constexpr std::size_t kMaxDatagram = 1200;
inline constexpr std::size_t kSealSize = 24;

using DatagramKey = std::array<std::uint8_t, 32>;
// Throws std::runtime_error without random numbers of the system.
DatagramKey NewDatagramKey();
// nullopt: wrong length.
std::optional<DatagramKey> DatagramKeyFrom(std::string_view bytes);

using CipherContext = std::unique_ptr<EVP_CIPHER_CTX, void (*)(EVP_CIPHER_CTX*)>;

// Sealer and opener are not thread-safe. They do not allocate after construction.
class DatagramSealer {
 public:
  // Throws std::runtime_error if OpenSSL lacks the cipher.
  explicit DatagramSealer(const DatagramKey& key);
  // The sealed datagram, valid until the next call. Empty if `plain` is empty or too large.
  std::span<const std::uint8_t> Seal(std::span<const std::uint8_t> plain) noexcept;

 private:
  CipherContext cipher_;
  std::uint64_t counter_ = 0;  // counter of the last datagram
  std::array<std::uint8_t, kMaxDatagram> sealed_{};
};

// DatagramOpener is not thread-safe.
class DatagramOpener {
 public:
  explicit DatagramOpener(const DatagramKey& key);
  // Decrypts a datagram that is authentic and newer than all before. Returns an empty span for
  // others, such as repetitions. The result is valid until the next call.
  std::span<const std::uint8_t> Open(std::span<const std::uint8_t> sealed) noexcept;
  [[nodiscard]] std::uint64_t newest() const noexcept {
    return newest_;
  }  // newest counter; 0: none

 private:
  CipherContext cipher_;
  std::uint64_t newest_ = 0;
  std::array<std::uint8_t, kMaxDatagram> plain_{};
};

}  // namespace palpate
