#include "master/device/haply/haply_line.h"

#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace palpate {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;
using asio::ip::tcp;
using beast::error_code;

constexpr std::size_t kMaxMessageLength = 1 << 20;  // [bytes]
constexpr const char* kHost = "127.0.0.1";

}  // namespace

// Each call runs the loop of events until its own operation is done, or the limit has passed.
struct HaplyLine::Parts {
  using Limit = std::chrono::milliseconds;

  // Runs until `done`. False: not within `limit`.
  bool Await(const bool& done, Limit limit) {
    const auto end = std::chrono::steady_clock::now() + limit;
    context.restart();
    while (!done && std::chrono::steady_clock::now() < end) context.run_one_until(end);
    if (!done) context.poll();  // processes results that are ready if this thread was delayed
    return done;
  }
  // Connects the stream to the service.
  bool Connect(beast::tcp_stream* stream, std::uint16_t port, Limit limit) {
    bool done = false;
    error_code failure;
    const tcp::endpoint at(asio::ip::make_address(kHost), port);
    stream->async_connect(at, [&](error_code error) {
      failure = error;
      done = true;
    });
    if (Await(done, limit)) return !failure;
    Cancel(stream, done);
    return false;
  }
  // Waits until the operation that uses local variables has ended.
  void Cancel(beast::tcp_stream* stream, const bool& done) {
    stream->close();
    context.restart();
    while (!done && context.run_one() != 0) {
    }
  }

  asio::io_context context{1};
  std::optional<websocket::stream<beast::tcp_stream>> socket;
  beast::flat_buffer received;
  bool reading = false, read = false;
  error_code read_error;
};

HaplyLine::HaplyLine(std::uint16_t port) : port_(port), parts_(std::make_unique<Parts>()) {}

HaplyLine::~HaplyLine() {
  Close();
}

std::optional<std::string> HaplyLine::Get(const std::string& path,
                                          std::chrono::milliseconds limit) const {
  Parts line;
  beast::tcp_stream stream(line.context);
  if (!line.Connect(&stream, port_, limit)) return std::nullopt;
  http::request<http::empty_body> request{http::verb::get, path, 11};
  request.set(http::field::host, std::string(kHost) + ":" + std::to_string(port_));
  request.set(http::field::connection, "close");
  bool done = false;
  error_code failure;
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  http::async_write(stream, request, [&](error_code error, std::size_t /*size*/) {
    failure = error;
    if (error) {
      done = true;
      return;
    }
    http::async_read(stream, buffer, response, [&](error_code also, std::size_t /*size*/) {
      failure = also;
      done = true;
    });
  });
  const bool in_time = line.Await(done, limit);
  if (!in_time) line.Cancel(&stream, done);
  if (!in_time || failure || response.result() != http::status::ok) return std::nullopt;
  return std::move(response.body());
}

bool HaplyLine::Open(std::chrono::milliseconds limit) {
  Close();
  auto& socket = parts_->socket.emplace(parts_->context);
  auto& stream = beast::get_lowest_layer(socket);
  if (!parts_->Connect(&stream, port_, limit)) return false;
  error_code ignored;
  stream.socket().set_option(tcp::no_delay(true), ignored);
  socket.read_message_max(kMaxMessageLength);
  bool done = false;
  error_code failure;
  socket.async_handshake(std::string(kHost) + ":" + std::to_string(port_), "/",
                         [&](error_code error) {
                           failure = error;
                           done = true;
                         });
  if (!parts_->Await(done, limit)) {
    parts_->Cancel(&stream, done);
    return false;
  }
  socket.text(true);
  return !failure;
}

void HaplyLine::Close() {
  if (!parts_->socket) return;
  beast::get_lowest_layer(*parts_->socket).close();
  parts_->context.restart();
  parts_->context.run();  // completes the cancelled operations
  parts_->socket.reset();
  parts_->received.clear();
  parts_->reading = parts_->read = false;
}

bool HaplyLine::Send(const std::string& text, std::chrono::milliseconds limit) {
  if (!parts_->socket) return false;
  bool done = false;
  error_code failure;
  parts_->socket->async_write(asio::buffer(text), [&](error_code error, std::size_t /*size*/) {
    failure = error;
    done = true;
  });
  if (parts_->Await(done, limit)) return !failure;
  parts_->Cancel(&beast::get_lowest_layer(*parts_->socket), done);
  return false;
}

HaplyLine::Received HaplyLine::Receive(std::chrono::milliseconds limit, std::string* text) {
  Parts& line = *parts_;
  if (!line.socket) return Received::kClosed;
  if (!line.reading) {
    line.reading = true;
    line.read = false;
    line.socket->async_read(line.received, [&line](error_code error, std::size_t /*size*/) {
      line.read_error = error;
      line.read = true;
    });
  }
  if (!line.Await(line.read, limit)) return Received::kNothingYet;
  line.reading = false;
  if (line.read_error) return Received::kClosed;
  *text = beast::buffers_to_string(line.received.data());
  line.received.clear();
  return Received::kMessage;
}

}  // namespace palpate
