#include <gtest/gtest.h>

#include "master/link/channel.h"

namespace palpate {
namespace {

struct Row {
  grpc::StatusCode code;
  std::string message, words;
};

class StatusWordsTest : public testing::TestWithParam<Row> {};

TEST_P(StatusWordsTest, StatesTheCause) {
  EXPECT_EQ(WordsOf({GetParam().code, GetParam().message}), GetParam().words);
}

// Messages of gRPC 1.51 about a connection, and messages of slaves.
INSTANTIATE_TEST_SUITE_P(
    All, StatusWordsTest,
    testing::Values(
        Row{grpc::StatusCode::DEADLINE_EXCEEDED, "Deadline Exceeded", "no answer in time"},
        Row{grpc::StatusCode::UNAVAILABLE,
            "failed to connect to all addresses; last error: UNKNOWN: ipv4:127.0.0.1:50051: Failed "
            "to connect to remote host: Connection refused",
            "no program listens there"},
        Row{grpc::StatusCode::UNAVAILABLE, "Socket closed", "the connection was closed"},
        Row{grpc::StatusCode::UNAVAILABLE, "the slave is stopping", "the slave is stopping"},
        Row{grpc::StatusCode::FAILED_PRECONDITION, "bob leads; Connection refused\x1b[2J",
            "bob leads; Connection refused [2J"},
        Row{grpc::StatusCode::INTERNAL, "", ""}));

TEST(StatusWordsLengthTest, TextsOfOthersAreShortenedToFit) {
  EXPECT_EQ(WordsOf({grpc::StatusCode::UNAVAILABLE, std::string(5000, 'a')}).size(), 300U);
}

}  // namespace
}  // namespace palpate
