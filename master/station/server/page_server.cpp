#include "master/station/server/page_server.h"

#include <algorithm>
#include <atomic>
#include <list>
#include <map>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/version.hpp>

#include "master/station/server/page_access.h"
#include "master/station/server/page_files.h"
#include "master/station/server/page_session.h"

namespace palpate {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using asio::ip::tcp;
using boost::beast::error_code;

constexpr std::chrono::seconds kAskWithin(5), kSetUpWithin(120);
constexpr std::chrono::milliseconds kGoodbyeWithin(200), kErrorPause(20);
constexpr std::uint32_t kMaxHeaderLength = 8192;  // [bytes]
constexpr std::string_view kSetUp = "/setup/";

using Reply = http::response<http::string_body>;

// The page may load, run and frame only content of the program.
void AddRules(Reply* reply) {
  reply->set("Content-Security-Policy",
             "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
             "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  reply->set("X-Content-Type-Options", "nosniff");
  reply->set("Referrer-Policy", "no-referrer");
  reply->set("Cross-Origin-Opener-Policy", "same-origin");
  reply->set("Cross-Origin-Resource-Policy", "same-origin");
  reply->set(http::field::cache_control, "no-store");
}

Reply MakeReply(http::status status, std::string_view type, std::string_view body) {
  Reply reply{status, 11};
  reply.set(http::field::content_type, {type.data(), type.size()});
  AddRules(&reply);
  reply.body() = std::string(body);
  reply.keep_alive(false);
  reply.prepare_payload();
  return reply;
}

Reply Refuse(http::status status, const std::string& why) {
  return MakeReply(status, "text/plain; charset=utf-8", why + "\n");
}

std::string_view View(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

Reply AnswerFile(const PageRequest& request) {
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return Refuse(http::status::method_not_allowed, "expected GET and HEAD");
  }
  const PageFile* file = FindPageFile(View(request.target()));
  if (file == nullptr) return Refuse(http::status::not_found, "no such file");
  Reply reply = MakeReply(http::status::ok, file->type, file->bytes);
  if (request.method() == http::verb::head) reply.body().clear();
  return reply;
}

// Returns the path of a request without its query.
std::string_view PathOf(const PageRequest& request) {
  const std::string_view target = View(request.target());
  return target.substr(0, target.find('?'));
}

bool IsSetUp(const PageRequest& request) {
  return request.method() == http::verb::post && PathOf(request).starts_with(kSetUp);
}

// State of an HTTP connection from the first byte to its only answer.
struct Caller : std::enable_shared_from_this<Caller> {
  Caller(tcp::socket&& socket, std::shared_ptr<asio::ssl::context> used,
         std::atomic<std::size_t>* callers, std::atomic<std::size_t>* all_arriving)
      : tls(std::move(used)),
        stream(std::move(socket), tls.get()),
        count(callers),
        arriving(all_arriving) {
    error_code ignored;
    address = stream.tcp().socket().remote_endpoint(ignored).address();
    ++*count;
    parser.header_limit(kMaxHeaderLength);
    parser.body_limit(PageServer::kMaxSetupBytes);
  }
  ~Caller() {
    --*count;
    *arriving -= announced;
  }
  void Answer(Reply&& made) {
    reply = std::move(made);
    http::async_write(stream, reply,
                      [self = shared_from_this()](error_code /*error*/, std::size_t /*bytes*/) {
                        error_code ignored;
                        self->stream.tcp().socket().shutdown(tcp::socket::shutdown_send, ignored);
                      });
  }

  std::shared_ptr<asio::ssl::context> tls;
  PageStream stream;
  asio::ip::address address;  // of the browser
  std::atomic<std::size_t>*count, *arriving;
  std::size_t announced = 0;  // length of its body, while that is part of `arriving` [bytes]
  bool asks = false;          // its request has arrived
  boost::beast::flat_buffer buffer;
  http::request_parser<http::empty_body> parser;
  std::optional<http::request_parser<http::string_body>> body;  // of a request of the set-up
  Reply reply;
};

}  // namespace

struct PageServer::Parts {
  Parts(const Endpoint& endpoint, const NoticeBoard* shown, Listener on_message, PageAccess asked)
      : board(shown), listener(std::move(on_message)), access(std::move(asked)), acceptor(context) {
    Listen(endpoint);
    const auto left = std::move(listener.left);
    listener.left = [this, left](std::uint64_t page) {
      --page_count;
      left(page);
    };
  }

  void Listen(const Endpoint& endpoint);
  void Accept();
  void Serve(tcp::socket&& socket);
  // Closes the connection that has been silent for longest, of the address with most of them.
  // False: none is silent.
  bool MakeRoom();
  // Removes from `waiting` who has asked or left.
  void ForgetAnswered();
  void Read(const std::shared_ptr<Caller>& caller);
  // Rejection of a request that acts on the slave, with its HTTP status; empty: accepted.
  [[nodiscard]] std::pair<http::status, std::string> Refusal(const PageRequest& request) const;
  void Answer(const std::shared_ptr<Caller>& caller);
  void ReadSetUp(const std::shared_ptr<Caller>& caller, const std::string& call);
  void SetUp(const std::shared_ptr<Caller>& caller, const std::string& call);
  void Open(Caller* caller, const PageRequest& request);
  void PumpAll();
  void Leave();

  const NoticeBoard* const board;
  Listener listener;
  PageAccess access;
  std::atomic<std::size_t> callers{0}, page_count{0}, arriving{0};
  std::list<std::weak_ptr<Caller>> waiting;  // in the order in which they came
  std::atomic<bool> is_notified{false};
  std::uint64_t last_page = 0;
  std::vector<std::weak_ptr<PageSession>> sessions;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  tcp::endpoint listening;
  asio::steady_timer error_pause{context}, goodbye{context};
  std::thread thread;
};

void PageServer::Parts::Listen(const Endpoint& endpoint) {
  try {
    const std::string host = endpoint.host == "localhost" ? "127.0.0.1" : endpoint.host;
    const tcp::endpoint at(asio::ip::make_address(host), endpoint.port);
    acceptor.open(at.protocol());
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind(at);
    acceptor.listen();
    listening = acceptor.local_endpoint();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("--view: cannot listen at " + ToString(endpoint) + ": " +
                             error.code().message());
  }
}

void PageServer::Parts::Accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (!acceptor.is_open()) return;
    const bool is_full = callers + page_count >= kMaxConnections;
    if (!error && (!is_full || MakeRoom())) Serve(std::move(socket));
    if (!error) return Accept();
    error_pause.expires_after(kErrorPause);  // for example, no file descriptors left
    error_pause.async_wait([this](error_code /*error*/) { Accept(); });
  });
}

void PageServer::Parts::Serve(tcp::socket&& socket) {
  RenewCertificate(&access);
  const auto caller = std::make_shared<Caller>(std::move(socket), access.tls, &callers, &arriving);
  ForgetAnswered();
  waiting.push_back(caller);
  caller->stream.tcp().expires_after(kAskWithin);
  caller->stream.Greet([this, caller](error_code error) {
    if (!error) Read(caller);
  });
}

void PageServer::Parts::ForgetAnswered() {
  waiting.remove_if([](const std::weak_ptr<Caller>& one) {
    const auto caller = one.lock();
    return !caller || caller->asks;
  });
}

bool PageServer::Parts::MakeRoom() {
  ForgetAnswered();
  std::map<asio::ip::address, std::size_t> counts;
  for (const auto& one : waiting) {
    if (const auto caller = one.lock()) ++counts[caller->address];
  }
  std::shared_ptr<Caller> oldest;
  for (const auto& one : waiting) {
    const auto caller = one.lock();
    if (caller && (!oldest || counts[caller->address] > counts[oldest->address])) oldest = caller;
  }
  if (!oldest) return false;
  error_code ignored;
  oldest->stream.tcp().socket().close(ignored);
  oldest->asks = true;  // its handlers end it
  return true;
}

void PageServer::Parts::Read(const std::shared_ptr<Caller>& caller) {
  http::async_read_header(caller->stream, caller->buffer, caller->parser,
                          [this, caller](error_code error, std::size_t /*bytes*/) {
                            if (!error) return Answer(caller);
                            if (error == boost::beast::error::timeout) return;
                            caller->Answer(Refuse(http::status::bad_request, error.message()));
                          });
}

void PageServer::Parts::Answer(const std::shared_ptr<Caller>& caller) {
  caller->asks = true;
  const PageRequest request = caller->parser.get();
  const std::string_view host = View(request[http::field::host]);
  const std::string stranger = access.tls ? std::string() : RefusalOfHost(host);
  if (!stranger.empty()) return caller->Answer(Refuse(http::status::misdirected_request, stranger));
  const bool sets_up = listener.set_up && IsSetUp(request);
  if (!sets_up && !boost::beast::websocket::is_upgrade(request)) {
    return caller->Answer(AnswerFile(request));
  }
  const auto [status, refused] = Refusal(request);
  if (!refused.empty()) return caller->Answer(Refuse(status, refused));
  if (sets_up) return ReadSetUp(caller, std::string(PathOf(request).substr(kSetUp.size())));
  if (page_count >= kMaxPages) {
    return caller->Answer(Refuse(http::status::service_unavailable, "8 pages are already open"));
  }
  Open(caller.get(), request);
}

std::pair<http::status, std::string> PageServer::Parts::Refusal(const PageRequest& request) const {
  const std::string foreign =
      RefusalOfOrigin(View(request[http::field::origin]), View(request[http::field::host]),
                      access.tls ? "https://" : "http://");
  if (!foreign.empty()) return {http::status::forbidden, foreign};
  if (!IsSetUp(request) && PathOf(request) != "/ws")
    return {http::status::not_found, "no such stream"};
  if (access.tls && !CarriesToken(View(request.target()), access.token)) {
    return {http::status::forbidden,
            "token: expected the one in the address that palpate-master printed"};
  }
  return {};
}

void PageServer::Parts::ReadSetUp(const std::shared_ptr<Caller>& caller, const std::string& call) {
  const auto length = caller->parser.content_length();
  caller->announced = length ? std::min<std::size_t>(*length, kMaxSetupBytes) : kMaxSetupBytes;
  arriving += caller->announced;
  if (arriving > kMaxArriving) {
    return caller->Answer(
        Refuse(http::status::service_unavailable, "other set-ups are being sent: try again"));
  }
  caller->stream.tcp().expires_after(kSetUpWithin);
  caller->body.emplace(std::move(caller->parser));
  http::async_read(caller->stream, caller->buffer, *caller->body,
                   [this, caller, call](error_code error, std::size_t /*bytes*/) {
                     if (!error) return SetUp(caller, call);
                     if (error == boost::beast::error::timeout) return;
                     caller->Answer(Refuse(http::status::bad_request, error.message()));
                   });
}

void PageServer::Parts::SetUp(const std::shared_ptr<Caller>& caller, const std::string& call) {
  listener.set_up(call, std::move(caller->body->get().body()),
                  [this, caller](int status, std::string json) {
                    asio::post(context, [caller, status, json = std::move(json)] {
                      caller->stream.tcp().expires_after(kSetUpWithin);
                      caller->Answer(MakeReply(http::int_to_status(static_cast<unsigned>(status)),
                                               "application/json", json));
                    });
                  });
}

void PageServer::Parts::Open(Caller* caller, const PageRequest& request) {
  ++page_count;
  const auto session =
      std::make_shared<PageSession>(std::move(caller->stream), ++last_page, board, &listener);
  std::erase_if(sessions, [](const auto& other) { return other.expired(); });
  sessions.push_back(session);
  session->Start(request);
}

void PageServer::Parts::PumpAll() {
  is_notified = false;
  for (const auto& session : sessions) {
    if (const auto open = session.lock()) open->Pump();
  }
}

void PageServer::Parts::Leave() {
  error_code ignored;
  acceptor.close(ignored);
  for (const auto& session : sessions) {
    if (const auto open = session.lock()) {
      open->Close(boost::beast::websocket::close_code::going_away, "the session has ended");
    }
  }
  goodbye.expires_after(kGoodbyeWithin);
  goodbye.async_wait([this](error_code /*error*/) { context.stop(); });
}

PageServer::PageServer(const Endpoint& endpoint, const NoticeBoard* board, Listener listener,
                       PageAccess access)
    : parts_(std::make_unique<Parts>(endpoint, board, std::move(listener), std::move(access))) {
  parts_->Accept();
  parts_->thread = std::thread([parts = parts_.get()] { parts->context.run(); });
}

PageServer::~PageServer() {
  asio::post(parts_->context, [parts = parts_.get()] { parts->Leave(); });
  parts_->thread.join();
}

Endpoint PageServer::endpoint() const {
  return {parts_->listening.address().to_string(), parts_->listening.port()};
}

std::string PageServer::address() const {
  const std::string at = "://" + ToString(endpoint()) + "/";
  return parts_->access.tls ? "https" + at + "#" + parts_->access.token : "http" + at;
}

std::size_t PageServer::pages() const {
  return parts_->page_count;
}

void PageServer::Notify() {
  if (parts_->is_notified.exchange(true)) return;
  asio::post(parts_->context, [parts = parts_.get()] { parts->PumpAll(); });
}

}  // namespace palpate
