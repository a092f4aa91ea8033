#include "master/station/server/notice_board.h"

#include <array>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// A topic that is always new does not keep the others from being sent.
TEST(NoticeBoardTest, SendsTheTopicsInTurn) {
  NoticeBoard board;
  NoticeBoard::Seen seen{};
  Topic last = Topic::kShape;
  std::array<int, kTopicCount> sent{};
  for (int i = 0; i < 60; ++i) {
    board.Put(Topic::kStatus, "s");
    board.Put(Topic::kImage, "p");
    board.Put(Topic::kShape, "m");
    const NoticeBoard::News news = board.Next(last, &seen);
    last = news.topic;
    ++sent[static_cast<std::size_t>(news.topic)];
  }
  for (const Topic topic : {Topic::kStatus, Topic::kImage, Topic::kShape}) {
    EXPECT_EQ(sent[static_cast<std::size_t>(topic)], 20);
  }
}

}  // namespace
}  // namespace palpate
