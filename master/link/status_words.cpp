#include "master/link/status_words.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kLongest = 300;  // [characters]

// A part of a gRPC message, and the words shown for it. The first match counts.
struct Row {
  std::string_view part, words;
};
constexpr std::array<Row, 12> kRows{{
    {"Deadline Exceeded", "no answer in time"},
    {"Connection refused", "no program listens there"},
    {"DNS resolution failed", "unknown host name"},
    {"Network is unreachable", "no route to that machine"},
    {"No route to host", "no route to that machine"},
    {"timed out", "that machine does not answer"},
    {"Timeout occurred", "that machine does not answer"},
    {"eepalive", "the slave no longer answers"},
    {"Socket closed", "the connection was closed"},
    {"Connection reset", "the connection was closed"},
    {"Broken pipe", "the connection was closed"},
    {"Endpoint read failed", "the connection was closed"},
}};

// Codes of the transport. The slave itself returns UNAVAILABLE only when it stops.
bool IsOfTheLine(grpc::StatusCode code) {
  return code == grpc::StatusCode::UNAVAILABLE || code == grpc::StatusCode::DEADLINE_EXCEEDED;
}

}  // namespace

std::string WordsOf(const grpc::Status& status) {
  const std::string& told = status.error_message();
  if (IsOfTheLine(status.error_code())) {
    const auto row = std::ranges::find_if(
        kRows, [&](const Row& one) { return told.find(one.part) != std::string::npos; });
    if (row != kRows.end()) return std::string(row->words);
  }
  return Presentable(told, kLongest);
}

}  // namespace palpate
