// The stream of a page for Boost.Beast: TCP in plain text or with TLS.
#pragma once

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket/teardown.hpp>

namespace palpate {

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

}  // namespace palpate
