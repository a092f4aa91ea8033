// The newest message of each topic, ready to be sent. A session or replay writes messages, and the
// server reads them for each page at its pace. There is no queue: a slow page loses old values,
// delays nobody and uses no additional memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

namespace palpate {

// Topics in the order in which a new page receives them. Text topics are JSON objects with `kind`.
// Binary topics begin with BinaryHeader.
enum class Topic : std::uint8_t {
  kHello,     // text: constants: scene, device, limits
  kTopology,  // binary: the object at rest
  kHealth,    // text: the slave's scene, capabilities and status, once a second
  kLog,       // text: events
  kStatus,    // text: status, 30 times a second
  kImage,     // binary: a JPEG
  kShape,     // binary: the deformed object
  // Binary: nodes and triangles of the displacement field, and the field. Only while a page
  // requests them (FieldCommand), or from a recording.
  kFieldTopology,
  kField,
};
inline constexpr std::size_t kTopicCount = 9;
constexpr bool IsBinary(Topic topic) {
  return topic == Topic::kTopology || topic == Topic::kImage || topic == Topic::kShape ||
         topic == Topic::kFieldTopology || topic == Topic::kField;
}

// Sixteen bytes before each binary message, little-endian.
struct BinaryHeader {
  std::uint32_t topic = 0;  // as Topic
  // Topologies: their number, from 1; shape and field: the topology's; image: 0.
  std::uint32_t number = 0;
  double t = 0;  // sample time since the start of the run [s]
};
static_assert(sizeof(BinaryHeader) == 16);
// Header and bytes together.
std::string Framed(const BinaryHeader& header, std::string_view bytes);

class NoticeBoard {
 public:
  using Bytes = std::shared_ptr<const std::string>;
  // Version of each topic that a page has received.
  using Seen = std::array<std::uint64_t, kTopicCount>;
  struct News {
    Topic topic = Topic::kHello;
    Bytes bytes;  // null: nothing new
  };

  void Put(Topic topic, std::string message);  // thread-safe
  // Returns the next topic after `last`, in cyclic order, that is newer than in `seen`, and updates
  // `seen`. Thread-safe.
  News Next(Topic last, Seen* seen) const;

 private:
  mutable std::mutex mutex_;  // guards the members below
  std::array<Bytes, kTopicCount> messages_;
  Seen versions_{};
};

}  // namespace palpate
