// PageSession serves one open page: its WebSocket from the handshake to the end. One message at a
// time is written. The others stay on the board, so that a slow page receives only the newest.
//
// A browser buffers messages without limit. A page that reports how many messages it has processed
// (a binary message: the count, four bytes, little-endian) is never sent more than kMaxAhead
// beyond them. Other pages are sent messages as fast as the connection allows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include "master/station/server/notice_board.h"
#include "master/station/server/page_server.h"

namespace palpate {

// The stream of a page for Boost.Beast: TCP in plain text or with TLS.
class PageStream {
 public:
  using executor_type = boost::beast::tcp_stream::executor_type;

  // `tls` must outlive the stream; null: plain text.
  PageStream(boost::asio::ip::tcp::socket&& socket, boost::asio::ssl::context* tls)
      : tcp_(std::make_unique<boost::beast::tcp_stream>(std::move(socket))) {
    if (tls != nullptr) tls_ = std::make_unique<Tls>(*tcp_, *tls);
  }

  executor_type get_executor() noexcept { return tcp_->get_executor(); }
  [[nodiscard]] boost::beast::tcp_stream& tcp() { return *tcp_; }

  // `done(error)` when both ends speak the same, at once in plain text.
  template <class Done>
  void Greet(Done&& done) {
    if (!tls_) return done(boost::system::error_code());
    tls_->async_handshake(boost::asio::ssl::stream_base::server, std::forward<Done>(done));
  }
  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    const auto list = Listed<boost::asio::mutable_buffer>(buffers);
    if (tls_) return tls_->async_read_some(list, Shared(std::forward<Handler>(handler)));
    tcp_->async_read_some(list, Shared(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    const auto list = Listed<boost::asio::const_buffer>(buffers);
    if (tls_) return tls_->async_write_some(list, Shared(std::forward<Handler>(handler)));
    tcp_->async_write_some(list, Shared(std::forward<Handler>(handler)));
  }

  friend void beast_close_socket(PageStream& stream) { stream.tcp().close(); }
  friend void teardown(boost::beast::role_type role, PageStream& stream,
                       boost::system::error_code& error) {
    boost::beast::websocket::teardown(role, stream.tcp().socket(), error);
  }
  // The WebSocket is closed already, so TLS sends no close message.
  template <class Handler>
  friend void async_teardown(boost::beast::role_type role, PageStream& stream, Handler&& handler) {
    boost::beast::websocket::async_teardown(role, stream.tcp().socket(),
                                            std::forward<Handler>(handler));
  }

 private:
  using Tls = boost::asio::ssl::stream<boost::beast::tcp_stream&>;

  // Converts buffers and handlers of Beast to one type each, which limits the compiled code.
  template <class Buffer, class Buffers>
  static std::vector<Buffer> Listed(const Buffers& buffers) {
    return {boost::asio::buffer_sequence_begin(buffers), boost::asio::buffer_sequence_end(buffers)};
  }
  using Done = std::function<void(boost::system::error_code, std::size_t)>;
  template <class Handler>
  static Done Shared(Handler&& handler) {
    auto shared = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return
        [shared](boost::system::error_code error, std::size_t bytes) { (*shared)(error, bytes); };
  }

  std::unique_ptr<boost::beast::tcp_stream> tcp_;  // keeps its address when the stream is moved
  std::unique_ptr<Tls> tls_;                       // null: plain text
};

using PageRequest = boost::beast::http::request<boost::beast::http::empty_body>;

// Used by the server's thread. Exists while one of its operations is pending.
class PageSession : public std::enable_shared_from_this<PageSession> {
 public:
  static constexpr std::uint32_t kMaxAhead = 8;
  static constexpr std::size_t kMaxAnswers = 8;  // waiting answers; the oldest are dropped

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
  void Receive(std::string_view message);
  void TakeCount(std::string_view count);
  [[nodiscard]] bool IsFlooding();
  void Write(bool binary, NoticeBoard::Bytes bytes);

  boost::beast::websocket::stream<PageStream> socket_;
  const std::uint64_t number_;
  const NoticeBoard* const board_;
  const PageServer::Listener* const listener_;
  boost::beast::flat_buffer received_;
  NoticeBoard::Seen seen_{};
  Topic last_ = Topic::kShape;       // the first topic comes first
  NoticeBoard::Bytes writing_;       // null: no pending write
  std::deque<std::string> answers_;  // not sent yet, at most kMaxAnswers
  bool open_ = false;
  std::uint32_t sent_ = 0;              // number of messages
  std::optional<std::uint32_t> taken_;  // processed messages; nullopt: the page does not report
  int requests_ = 0;                    // since `counting_since_`
  std::chrono::steady_clock::time_point counting_since_{};
};

}  // namespace palpate
