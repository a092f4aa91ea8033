#include "master/station/server/page_session.h"

#include <cstring>
#include <stdexcept>
#include <utility>

#include "master/station/server/page_command.h"

namespace palpate {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr std::chrono::seconds kHandshakeWithin(5), kSilentPageAfter(10);
constexpr std::size_t kMaxReasonLength = 120;  // a close frame has at most 123 bytes
// [bytes]; small, because buffered data are old when they arrive.
constexpr int kSendBuffer = 1 << 17;

websocket::stream_base::timeout Timeouts() {
  return {kHandshakeWithin, kSilentPageAfter, true};
}

}  // namespace

PageSession::PageSession(PageStream&& stream, std::uint64_t number, const NoticeBoard* board,
                         const PageServer::Listener* listener)
    : socket_(std::move(stream)), number_(number), board_(board), listener_(listener) {
  socket_.next_layer().tcp().expires_never();
  beast::error_code ignored;
  auto& tcp = socket_.next_layer().tcp().socket();
  tcp.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
  tcp.set_option(boost::asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  socket_.set_option(Timeouts());
  socket_.read_message_max(kMaxCommandBytes);
}

PageSession::~PageSession() {
  listener_->left(number_);
}

void PageSession::Start(const PageRequest& request) {
  socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
    if (error) return;
    self->open_ = true;
    self->Read();
    self->Pump();
  });
}

void PageSession::Read() {
  received_.clear();
  socket_.async_read(
      received_, [self = shared_from_this()](beast::error_code error, std::size_t bytes) {
        if (error) {
          self->open_ = false;
          self->socket_.next_layer().tcp().cancel();
          return;
        }
        self->Receive({static_cast<const char*>(self->received_.data().data()), bytes});
      });
}

void PageSession::Receive(std::string_view message) {
  if (!open_) return Read();  // reads until the closing frame is answered
  if (IsFlooding()) {
    Close(websocket::close_code::policy_error, "more than 500 messages in a second");
    return Read();
  }
  try {
    if (socket_.got_binary()) {
      TakeCount(message);
    } else if (std::string answer = listener_->receive(number_, message); !answer.empty()) {
      answers_.push_back(std::move(answer));
      if (answers_.size() > kMaxAnswers) answers_.pop_front();
    }
  } catch (const std::invalid_argument& error) {
    Close(websocket::close_code::policy_error, error.what());
  }
  Pump();
  Read();
}

void PageSession::TakeCount(std::string_view count) {
  std::uint32_t taken = 0;
  if (count.size() == sizeof taken) std::memcpy(&taken, count.data(), sizeof taken);
  if (count.size() != sizeof taken || taken > sent_) {
    throw std::invalid_argument("not understood: expected the number of messages received");
  }
  taken_ = taken;
}

bool PageSession::IsFlooding() {
  const auto now = std::chrono::steady_clock::now();
  if (now - counting_since_ > std::chrono::seconds(1)) {
    counting_since_ = now;
    requests_ = 0;
  }
  return ++requests_ > PageServer::kMaxCommands;
}

void PageSession::Pump() {
  if (!open_ || writing_ || (taken_ && sent_ - *taken_ >= kMaxAhead)) return;
  if (!answers_.empty()) {
    const auto answer = std::make_shared<const std::string>(std::move(answers_.front()));
    answers_.pop_front();
    return Write(false, answer);
  }
  NoticeBoard::News news = board_->Next(last_, &seen_);
  last_ = news.topic;
  if (news.bytes) Write(IsBinary(news.topic), std::move(news.bytes));
}

void PageSession::Write(bool binary, NoticeBoard::Bytes bytes) {
  writing_ = std::move(bytes);
  ++sent_;
  socket_.binary(binary);
  socket_.async_write(boost::asio::buffer(*writing_),
                      [self = shared_from_this()](beast::error_code error, std::size_t /*bytes*/) {
                        self->writing_ = nullptr;
                        if (!error) self->Pump();
                      });
}

void PageSession::Close(websocket::close_code code, const std::string& why) {
  if (!std::exchange(open_, false)) return;
  socket_.async_close({code, why.substr(0, kMaxReasonLength)},
                      [self = shared_from_this()](beast::error_code /*error*/) {});
}

}  // namespace palpate
