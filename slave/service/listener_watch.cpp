#include "slave/service/listener_watch.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

// One of the machine's own addresses for a listener on all of them.
std::string HostToAsk(const std::string& host) {
  if (host == "0.0.0.0") return "127.0.0.1";
  return host == "::" ? "::1" : host;
}

bool WaitFor(int fd, short event, std::chrono::milliseconds patience) {
  pollfd one{fd, event, 0};
  return poll(&one, 1, static_cast<int>(patience.count())) > 0;
}

std::string_view WordsOf(Greeting greeting) {
  using namespace std::string_view_literals;
  if (greeting == Greeting::kHttp2) return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"sv;
  return "\x16\x03\x01\x00\x05\x01\x00\x00\x01\x00"sv;
}

bool AnswersAt(const addrinfo& address, Greeting greeting, std::chrono::milliseconds patience) {
  const int fd = socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return false;
  static_cast<void>(connect(fd, address.ai_addr, address.ai_addrlen));  // in progress
  bool answers = WaitFor(fd, POLLOUT, patience);
  const std::string_view words = WordsOf(greeting);
  answers = answers && send(fd, words.data(), words.size(), MSG_NOSIGNAL) > 0;
  answers = answers && WaitFor(fd, POLLIN, patience);
  close(fd);
  return answers;
}

}  // namespace

bool Answers(const Endpoint& endpoint, Greeting greeting, std::chrono::milliseconds patience) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(endpoint.port);
  if (getaddrinfo(HostToAsk(endpoint.host).c_str(), port.c_str(), &hints, &found) != 0)
    return false;
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    if (AnswersAt(*one, greeting, patience)) return true;
  }
  return false;
}

ListenerWatch::ListenerWatch(Endpoint endpoint, std::function<void()> on_deaf,
                             const Options& options)
    : thread_([endpoint = std::move(endpoint), on_deaf = std::move(on_deaf),
               options](const std::stop_token& stop) {
        std::mutex mutex;
        std::condition_variable_any never;
        std::unique_lock lock(mutex);
        for (int missed = 0; missed < options.misses;) {
          never.wait_for(lock, stop, options.period, [] { return false; });
          if (stop.stop_requested()) return;
          missed = Answers(endpoint, options.greeting, options.patience) ? 0 : missed + 1;
          if (missed > 0 && options.on_missed) options.on_missed(missed);
        }
        on_deaf();
      }) {}

}  // namespace palpate
