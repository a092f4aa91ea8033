#include "master/station/server/notice_board.h"

#include <array>
#include <cstring>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(NoticeBoardTest, TellsTheNewestOfEachTopicOnce) {
  NoticeBoard board;
  board.Put(Topic::kStatus, "old");
  board.Put(Topic::kStatus, "new");
  board.Put(Topic::kHello, "hello");
  NoticeBoard::Seen seen{};
  const NoticeBoard::News first = board.Next(Topic::kShape, &seen);
  EXPECT_EQ(first.topic, Topic::kHello);
  const NoticeBoard::News second = board.Next(first.topic, &seen);
  EXPECT_EQ(*second.bytes, "new");
  EXPECT_EQ(board.Next(second.topic, &seen).bytes, nullptr);
}

// A topic that is always new does not keep the others from being sent.
TEST(NoticeBoardTest, GoesRoundTheTopics) {
  NoticeBoard board;
  NoticeBoard::Seen seen{};
  Topic last = Topic::kShape;
  std::array<int, kTopicCount> sent{};
  for (int i = 0; i < 60; ++i) {
    board.Put(Topic::kStatus, "s");
    board.Put(Topic::kPicture, "p");
    board.Put(Topic::kShape, "m");
    const NoticeBoard::News news = board.Next(last, &seen);
    last = news.topic;
    ++sent[static_cast<std::size_t>(news.topic)];
  }
  for (const Topic topic : {Topic::kStatus, Topic::kPicture, Topic::kShape}) {
    EXPECT_EQ(sent[static_cast<std::size_t>(topic)], 20);
  }
}

TEST(NoticeBoardTest, FramesAreReadBackByTheirOffsets) {
  const std::string message = Framed({5, 7, 1.5}, "jpeg");
  ASSERT_EQ(message.size(), 20U);
  EXPECT_EQ(message[0], 5);
  EXPECT_EQ(message[4], 7);
  double t = 0;
  std::memcpy(&t, message.data() + 8, sizeof t);
  EXPECT_EQ(t, 1.5);
  EXPECT_EQ(message.substr(16), "jpeg");
}

}  // namespace
}  // namespace palpate
