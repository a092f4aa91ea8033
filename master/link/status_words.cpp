#include "master/link/status_words.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kLongest = 300;  // [characters]

// What gRPC's own words hold, the first that is found; what is the case.
struct Row {
  std::string_view part, words;
};
constexpr std::array<Row, 12> kRows{{
    {"Deadline Exceeded", "no answer in time"},
    {"Connection refused", "nobody listens there"},
    {"DNS resolution failed", "no machine is known by that name"},
    {"Network is unreachable", "the network has no way to that machine"},
    {"No route to host", "the network has no way to that machine"},
    {"timed out", "that machine does not answer"},
    {"Timeout occurred", "that machine does not answer"},
    {"eepalive", "the slave does not answer any more"},
    {"Socket closed", "the connection broke"},
    {"Connection reset", "the connection broke"},
    {"Broken pipe", "the connection broke"},
    {"Endpoint read failed", "the connection broke"},
}};

// No service of ours answers with these but for `UNAVAILABLE`, when it stops.
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
