#include "shared/link/datagram_seal.h"

#include <algorithm>
#include <stdexcept>

#include <openssl/evp.h>
#include <openssl/rand.h>

namespace palpate {
namespace {

constexpr std::size_t kCounterSize = 8, kTagSize = 16, kNonceSize = 12;
static_assert(kCounterSize + kTagSize == kSealSize);

using Nonce = std::array<std::uint8_t, kNonceSize>;
constexpr auto kCounterAt = kNonceSize - kCounterSize;  // zeros before it

Nonce NonceOf(std::uint64_t counter) {
  Nonce nonce{};
  for (std::size_t i = kNonceSize; i-- > kCounterAt; counter >>= 8U) {
    nonce[i] = static_cast<std::uint8_t>(counter);
  }
  return nonce;
}

CipherContext MakeCipher(const DatagramKey& key, bool seals) {
  CipherContext cipher(EVP_CIPHER_CTX_new(), EVP_CIPHER_CTX_free);
  if (!cipher || EVP_CipherInit_ex(cipher.get(), EVP_chacha20_poly1305(), nullptr, key.data(),
                                   nullptr, seals ? 1 : 0) != 1) {
    throw std::runtime_error("OpenSSL has no ChaCha20-Poly1305");
  }
  return cipher;
}

// Encrypts or decrypts with the key and direction of the context.
bool Begin(EVP_CIPHER_CTX* cipher, const Nonce& nonce) {
  return EVP_CipherInit_ex(cipher, nullptr, nullptr, nullptr, nonce.data(), -1) == 1;
}

// A stream cipher returns as many bytes as it gets, in one call.
bool Pass(EVP_CIPHER_CTX* cipher, std::span<const std::uint8_t> in, std::uint8_t* out) {
  int passed = 0;
  return EVP_CipherUpdate(cipher, out, &passed, in.data(), static_cast<int>(in.size())) == 1;
}

bool Finish(EVP_CIPHER_CTX* cipher, std::uint8_t* end) {
  int more = 0;
  return EVP_CipherFinal_ex(cipher, end, &more) == 1;
}

}  // namespace

DatagramKey NewDatagramKey() {
  DatagramKey key{};
  if (RAND_bytes(key.data(), static_cast<int>(key.size())) != 1) {
    throw std::runtime_error("no random numbers");
  }
  return key;
}

std::optional<DatagramKey> DatagramKeyFrom(std::string_view bytes) {
  DatagramKey key{};
  if (bytes.size() != key.size()) return std::nullopt;
  std::ranges::copy(bytes, key.begin());
  return key;
}

DatagramSealer::DatagramSealer(const DatagramKey& key) : cipher_(MakeCipher(key, true)) {}

std::span<const std::uint8_t> DatagramSealer::Seal(std::span<const std::uint8_t> plain) noexcept {
  if (plain.empty() || plain.size() > sealed_.size() - kSealSize) return {};
  const Nonce nonce = NonceOf(++counter_);
  std::uint8_t* const text = std::copy(nonce.begin() + kCounterAt, nonce.end(), sealed_.begin());
  std::uint8_t* const tag = text + plain.size();
  EVP_CIPHER_CTX* const cipher = cipher_.get();
  const bool is_sealed = Begin(cipher, nonce) && Pass(cipher, plain, text) && Finish(cipher, tag) &&
                         EVP_CIPHER_CTX_ctrl(cipher, EVP_CTRL_AEAD_GET_TAG, kTagSize, tag) == 1;
  if (!is_sealed) return {};
  return std::span(sealed_).first(plain.size() + kSealSize);
}

DatagramOpener::DatagramOpener(const DatagramKey& key) : cipher_(MakeCipher(key, false)) {}

std::span<const std::uint8_t> DatagramOpener::Open(std::span<const std::uint8_t> sealed) noexcept {
  if (sealed.size() <= kSealSize || sealed.size() > kMaxDatagram) return {};
  std::uint64_t counter = 0;
  for (const std::uint8_t byte : sealed.first(kCounterSize)) counter = counter << 8U | byte;
  if (counter <= newest_) return {};
  const auto text = sealed.subspan(kCounterSize, sealed.size() - kSealSize);
  std::array<std::uint8_t, kTagSize> tag{};
  std::ranges::copy(sealed.last(kTagSize), tag.begin());
  EVP_CIPHER_CTX* const cipher = cipher_.get();
  const bool is_authentic =
      Begin(cipher, NonceOf(counter)) &&
      EVP_CIPHER_CTX_ctrl(cipher, EVP_CTRL_AEAD_SET_TAG, kTagSize, tag.data()) == 1 &&
      Pass(cipher, text, plain_.data()) && Finish(cipher, plain_.data() + text.size());
  if (!is_authentic) return {};
  newest_ = counter;
  return std::span(plain_).first(text.size());
}

}  // namespace palpate
