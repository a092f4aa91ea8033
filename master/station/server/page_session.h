// One open page: its WebSocket from the handshake to its end. One message at a time is written. The
// others stay on the board, so that a slow page receives only the newest.
//
// A browser buffers messages without limit. A page that reports how many messages it has processed
// (a binary message: the count, four bytes, little-endian) is never sent more than kMostAhead
// beyond them. Other pages are sent messages as fast as the connection allows.
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

#include "master/station/server/notice_board.h"
#include "master/station/server/page_server.h"
#include "master/station/server/page_stream.h"

namespace palpate {

using PageRequest = boost::beast::http::request<boost::beast::http::empty_body>;

// Used by the server's thread. Exists while one of its operations is pending.
class PageSession : public std::enable_shared_from_this<PageSession> {
 public:
  static constexpr std::uint32_t kMostAhead = 8;
  static constexpr std::size_t kMostAnswers = 8;  // waiting answers; the oldest are dropped

  PageSession(PageStream&& stream, std::uint64_t number, const NoticeBoard* board,
              const PageServer::Listener* listener);
  ~PageSession();

  // Answers the handshake, then reads and writes until it ends.
  void Start(const PageRequest& request);
  // Writes a new message, unless a write is pending.
  void Pump();
  // Sends the reason and closes.
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
  Topic last_ = Topic::kFindings;    // the first topic comes first
  NoticeBoard::Bytes writing_;       // null: no pending write
  std::deque<std::string> answers_;  // not sent yet, at most kMostAnswers
  bool open_ = false;
  std::uint32_t sent_ = 0;              // number of messages
  std::optional<std::uint32_t> taken_;  // processed messages; nullopt: the page does not report
  int requests_ = 0;                    // since `counting_since_`
  std::chrono::steady_clock::time_point counting_since_{};
};

}  // namespace palpate
