#include "shared/metrics/metrics_page.h"

#include <chrono>
#include <cmath>
#include <list>
#include <stdexcept>
#include <thread>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using beast::error_code;

// Time limit of a request from its first byte to the last. A new request is accepted at once; the
// oldest one is closed if there are too many.
constexpr std::chrono::seconds kTimeout(1);
constexpr std::size_t kMaxClients = 16;
// Pause after an error such as a lack of descriptors.
constexpr std::chrono::milliseconds kErrorPause(20);
constexpr std::uint32_t kMaxHeaderLength = 8192;  // [bytes]

Endpoint Permitted(const std::string& address, bool insecure) {
  try {
    return MetricsEndpoint(address, insecure);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
  }
}

// A connection, for one answer.
struct Client {
  explicit Client(tcp::socket&& socket) : stream(std::move(socket)) {
    stream.expires_after(kTimeout);
    parser.header_limit(kMaxHeaderLength);
  }

  beast::tcp_stream stream;
  beast::flat_buffer buffer;
  http::request_parser<http::empty_body> parser;
  http::response<http::string_body> answer;
};

constexpr std::size_t kMaxValueLength = 200;  // [characters]

void AppendValue(double value, std::string* text) {
  if (std::isnan(value)) {
    *text += "NaN\n";
  } else if (std::isinf(value)) {
    *text += value > 0 ? "+Inf\n" : "-Inf\n";
  } else {
    AppendNumber(value, '\n', text);
  }
}

void Append(const Metric& metric, std::string* text) {
  *text += "# HELP " + metric.name + ' ' + metric.help + '\n';
  *text +=
      "# TYPE " + metric.name + (metric.type == Metric::Type::kCounter ? " counter\n" : " gauge\n");
  for (const Metric::Sample& sample : metric.samples) {
    *text += metric.name;
    if (!sample.label.empty()) *text += '{' + sample.label + '}';
    *text += ' ';
    AppendValue(sample.value, text);
  }
}

}  // namespace

Endpoint MetricsEndpoint(const std::string& address, bool insecure) {
  Endpoint endpoint;
  try {
    endpoint = ParseEndpoint(address);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("--metrics: ") + error.what());
  }
  if (insecure || IsLoopback(endpoint.host)) return endpoint;
  throw std::invalid_argument(
      "--metrics: " + address +
      ": without --insecure, expected a loopback address (127.0.0.1, [::1] or localhost): the "
      "numbers are sent in plain text to anyone");
}

struct MetricsPage::Parts {
  explicit Parts(std::function<Metrics()> asked) : collect(std::move(asked)) {}

  // Throws boost::system::system_error.
  void Listen();
  void Accept();
  void Read(const std::shared_ptr<Client>& client);
  void Answer(const std::shared_ptr<Client>& client);

  const std::function<Metrics()> collect;
  Endpoint endpoint;
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  asio::steady_timer error_pause{context};
  std::list<std::weak_ptr<Client>> clients;  // oldest first
  std::jthread thread;
};

void MetricsPage::Parts::Listen() {
  const auto found = tcp::resolver(context).resolve(endpoint.host, std::to_string(endpoint.port));
  const tcp::endpoint at = *found.begin();
  acceptor.open(at.protocol());
  acceptor.set_option(tcp::acceptor::reuse_address(true));
  acceptor.bind(at);
  acceptor.listen();
  endpoint.port = acceptor.local_endpoint().port();
}

void MetricsPage::Parts::Accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (error) {
      error_pause.expires_after(kErrorPause);
      return error_pause.async_wait([this](error_code /*error*/) { Accept(); });
    }
    clients.remove_if([](const auto& other) { return other.expired(); });
    if (clients.size() >= kMaxClients) {
      if (const auto eldest = clients.front().lock()) eldest->stream.close();
      clients.pop_front();
    }
    const auto client = std::make_shared<Client>(std::move(socket));
    clients.push_back(client);
    Read(client);
    Accept();
  });
}

void MetricsPage::Parts::Read(const std::shared_ptr<Client>& client) {
  http::async_read_header(client->stream, client->buffer, client->parser,
                          [this, client](error_code error, std::size_t /*bytes*/) {
                            if (!error) Answer(client);
                          });
}

void MetricsPage::Parts::Answer(const std::shared_ptr<Client>& client) {
  const auto& request = client->parser.get();
  auto& answer = client->answer;
  answer.version(11);
  answer.set(http::field::content_type, "text/plain; version=0.0.4");
  answer.keep_alive(false);
  const std::string_view target(request.target().data(), request.target().size());
  if (request.method() != http::verb::get) {
    answer.result(http::status::method_not_allowed);
  } else if (target.substr(0, target.find('?')) != "/metrics") {
    answer.result(http::status::not_found);
  } else {
    answer.body() = ToText(collect());
  }
  answer.prepare_payload();
  http::async_write(client->stream, answer, [client](error_code, std::size_t) {
    error_code ignored;
    client->stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
  });
}

MetricsPage::MetricsPage(const std::string& address, bool insecure,
                         std::function<Metrics()> collect)
    : parts_(std::make_unique<Parts>(std::move(collect))) {
  parts_->endpoint = Permitted(address, insecure);
  try {
    parts_->Listen();
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("--metrics: cannot listen on " + address + ": " +
                             error.code().message());
  }
  parts_->Accept();
  parts_->thread = std::jthread([parts = parts_.get()] { parts->context.run(); });
}

MetricsPage::~MetricsPage() {
  parts_->context.stop();
}

const Endpoint& MetricsPage::endpoint() const {
  return parts_->endpoint;
}

std::string Label(std::string_view name, std::string_view value) {
  std::string label = std::string(name) + "=\"";
  for (const char c : Presentable(value, kMaxValueLength)) {
    if (c == '"' || c == '\\') label += '\\';
    label += c;
  }
  return label + '"';
}

Metric Gauge(std::string name, std::string help, double value) {
  return {std::move(name), std::move(help), Metric::Type::kGauge, {{"", value}}};
}

Metric Counter(std::string name, std::string help, double value) {
  return {std::move(name), std::move(help), Metric::Type::kCounter, {{"", value}}};
}

std::string ToText(const Metrics& metrics) {
  std::string text;
  for (const Metric& metric : metrics) Append(metric, &text);
  return text;
}

}  // namespace palpate
