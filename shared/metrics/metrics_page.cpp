#include "shared/metrics/metrics_page.h"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include <httplib.h>
#include <sys/socket.h>

namespace palpate {
namespace {

constexpr std::chrono::seconds kPatience(1);  // with who asks

// One after the other: who connects meanwhile waits in the system's queue, which is short.
class InTurn final : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> answer) override { answer(); }
  void shutdown() override {}
};

// The library would share a port with whoever has it, and say nothing.
void AloneOnItsPort(socket_t socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

Endpoint Permitted(const std::string& address, bool insecure) {
  try {
    return MetricsEndpoint(address, insecure);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
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
      ": accepted without --insecure is a loopback address (127.0.0.1, [::1] or localhost): the "
      "numbers go in plain text to whoever asks");
}

struct MetricsPage::Parts {
  Endpoint endpoint;
  httplib::Server server;
  std::atomic<bool> ended{false};
  std::jthread thread;
};

MetricsPage::MetricsPage(const std::string& address, bool insecure,
                         std::function<Metrics()> collect)
    : parts_(std::make_unique<Parts>()) {
  parts_->endpoint = Permitted(address, insecure);
  httplib::Server& server = parts_->server;
  server.new_task_queue = [] { return new InTurn; };
  server.set_socket_options(AloneOnItsPort);
  server.set_keep_alive_max_count(1);
  server.set_keep_alive_timeout(kPatience.count());
  server.set_read_timeout(kPatience);
  server.set_write_timeout(kPatience);
  server.set_payload_max_length(0);
  server.Get("/metrics", [collect = std::move(collect)](const auto&, httplib::Response& answer) {
    answer.set_content(ToText(collect()), "text/plain; version=0.0.4");
  });
  Endpoint& at = parts_->endpoint;
  const int port = at.port == 0 ? server.bind_to_any_port(at.host)
                                : (server.bind_to_port(at.host, at.port) ? at.port : -1);
  if (port <= 0) throw std::runtime_error("--metrics: cannot listen on " + address);
  at.port = static_cast<std::uint16_t>(port);
  parts_->thread = std::jthread([parts = parts_.get()] {
    parts->server.listen_after_bind();
    parts->ended = true;
  });
}

MetricsPage::~MetricsPage() {
  // A server that does not run yet cannot be stopped.
  while (!parts_->server.is_running() && !parts_->ended) std::this_thread::yield();
  parts_->server.stop();
}

const Endpoint& MetricsPage::endpoint() const {
  return parts_->endpoint;
}

}  // namespace palpate
