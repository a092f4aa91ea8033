#include "master/station/server/notice_board.h"

#include <bit>
#include <cstring>
#include <utility>

namespace palpate {

static_assert(std::endian::native == std::endian::little, "BinaryHeader is sent as it lies there");

std::string Framed(const BinaryHeader& header, std::string_view bytes) {
  std::string message(sizeof(header) + bytes.size(), '\0');
  std::memcpy(message.data(), &header, sizeof(header));
  std::memcpy(message.data() + sizeof(header), bytes.data(), bytes.size());
  return message;
}

void NoticeBoard::Put(Topic topic, std::string message) {
  auto bytes = std::make_shared<const std::string>(std::move(message));
  const std::scoped_lock lock(mutex_);
  messages_[static_cast<std::size_t>(topic)].swap(bytes);
  ++versions_[static_cast<std::size_t>(topic)];
}

NoticeBoard::News NoticeBoard::Next(Topic last, Seen* seen) const {
  const std::scoped_lock lock(mutex_);
  for (std::size_t step = 1; step <= kTopicCount; ++step) {
    const std::size_t i = (static_cast<std::size_t>(last) + step) % kTopicCount;
    if (versions_[i] == (*seen)[i]) continue;
    (*seen)[i] = versions_[i];
    return {static_cast<Topic>(i), messages_[i]};
  }
  return {last, nullptr};
}

}  // namespace palpate
