// What the station's pages show, as messages ready to be sent: of each topic the newest only. A
// live session writes here, a replay may; the server reads for each page at that page's pace.
// Nothing waits in a queue, so a slow page loses old values, delays nobody and grows no memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

namespace palpate {

// In the order in which a new page is told. Text topics are JSON objects with `kind`, binary ones
// begin with BinaryHeader.
enum class Topic : std::uint8_t {
  kHello,     // text: what does not change: scene, device, limits
  kTopology,  // binary: the object at rest
  kHealth,    // text: the slave's scene, capabilities and status, once a second
  kSaid,      // text: what happened, in words
  kStatus,    // text: the moment, 30 times a second
  kPicture,   // binary: a JPEG
  kShape,     // binary: the deformed object
  kFindings,  // text: what the doctor found when somebody asked
};
inline constexpr std::size_t kTopicCount = 8;
constexpr bool IsBinary(Topic topic) {
  return topic == Topic::kTopology || topic == Topic::kPicture || topic == Topic::kShape;
}

// Sixteen bytes before each binary message, little-endian.
struct BinaryHeader {
  std::uint32_t topic = 0;   // as Topic
  std::uint32_t number = 0;  // topology: its number, from 1; shape: the topology's; picture: 0
  double t = 0;              // when it was sensed [s] since the run began
};
static_assert(sizeof(BinaryHeader) == 16);
// Header and bytes together.
std::string Framed(const BinaryHeader& header, std::string_view bytes);

class NoticeBoard {
 public:
  using Bytes = std::shared_ptr<const std::string>;
  // What a page has seen of each topic.
  using Seen = std::array<std::uint64_t, kTopicCount>;
  struct News {
    Topic topic = Topic::kHello;
    Bytes bytes;  // null: nothing new
  };

  void Put(Topic topic, std::string message);  // thread-safe
  // The next topic after `last`, in rising order and round again, that is newer than `seen`, which
  // is brought up to date. Thread-safe.
  News Next(Topic last, Seen* seen) const;

 private:
  mutable std::mutex mutex_;  // guards what follows
  std::array<Bytes, kTopicCount> messages_;
  Seen versions_{};
};

}  // namespace palpate
