// One page that looks: its WebSocket from the handshake to its end. Of what it is sent one message
// is on its way, the rest is on the board: a page that reads slowly gets the newest, later.
//
// A browser reads what its page has no time for, and keeps it without end. A page that says how
// many messages it has taken (a binary message: the count, four bytes, little-endian) is never sent
// more than kMostAhead beyond them; others as fast as their line goes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "master/station/notice_board.h"
#include "master/station/server/page_server.h"
#include "master/station/server/page_stream.h"

namespace palpate {

using PageRequest = boost::beast::http::request<boost::beast::http::empty_body>;

// Belongs to the server's thread; lives as long as one of its operations.
class PageSession : public std::enable_shared_from_this<PageSession> {
 public:
  static constexpr std::uint32_t kMostAhead = 8;
  static constexpr std::size_t kMostAnswers = 8;  // that wait; the oldest go

  PageSession(PageStream&& stream, std::uint64_t number, const NoticeBoard* board,
              const PageServer::Listener* listener);
  ~PageSession();

  // Answers the handshake, then reads and writes until it ends.
  void Start(const PageRequest& request);
  // Writes what is new, unless it is writing.
  void Pump();
  // Says why, and ends.
  void Close(boost::beast::websocket::close_code code, const std::string& why);

 private:
  void Read();
  void Hear(std::string_view said);
  void Take(std::string_view count);
  [[nodiscard]] bool IsFlooding();
  void Write(bool binary, NoticeBoard::Bytes bytes);

  boost::beast::websocket::stream<PageStream> socket_;
  const std::uint64_t number_;
  const NoticeBoard* const board_;
  const PageServer::Listener* const listener_;
  boost::beast::flat_buffer heard_;
  NoticeBoard::Seen seen_{};
  Topic last_ = Topic::kFindings;    // so that what comes first is told first
  NoticeBoard::Bytes writing_;       // null: nothing is on its way
  std::deque<std::string> answers_;  // not sent yet, at most kMostAnswers
  bool open_ = false;
  std::uint32_t sent_ = 0;              // messages
  std::optional<std::uint32_t> taken_;  // of them; nullopt: the page does not say
  int requests_ = 0;                    // since `counting_since_`
  std::chrono::steady_clock::time_point counting_since_{};
};

}  // namespace palpate
