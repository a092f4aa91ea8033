#include "shared/nats/nats_connection.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <nats/nats.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::string_view kRoot = "palpate.";
constexpr int kConnectMs = 1000, kConfirmMs = 400, kWriteMs = 500;
constexpr std::chrono::milliseconds kRetry(200);
constexpr int kPingMs = 2000, kPingsOut = 2;  // a server that is silent for 4 s is considered lost
constexpr std::chrono::seconds kCloseWait(2);
constexpr std::size_t kMaxReasonLength = 200;

struct Free {
  void operator()(natsOptions* options) const { natsOptions_Destroy(options); }
  void operator()(natsConnection* connection) const { natsConnection_Destroy(connection); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

void Check(natsStatus status, const std::string& what) {
  if (status == NATS_OK) return;
  throw std::invalid_argument(what + ": " + natsStatus_GetText(status));
}

// Returns `: reason` without the library's source position; empty: unknown.
std::string WordsOf(std::string_view why) {
  const std::size_t place = why.starts_with("(conn.c:") ? why.find("): ") : std::string_view::npos;
  if (place != std::string_view::npos) why.remove_prefix(place + 3);
  return why.empty() ? std::string() : ": " + Presentable(why, kMaxReasonLength);
}
std::string WordsOf(natsConnection* connection) {
  const char* why = nullptr;
  natsConnection_GetLastError(connection, &why);
  return WordsOf(std::string_view(why != nullptr ? why : ""));
}

// Removes quotes, because the library does not escape the name in JSON.
std::string WithoutQuotes(std::string name) {
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return c == '"' || c == '\\' || std::iscntrl(c) != 0; }, '-');
  return name;
}

}  // namespace

NatsServer ParseNatsServer(const std::string& url, bool insecure,
                           const std::filesystem::path& tls) {
  NatsServer server{.url = url, .tls = tls};
  server.encrypted = url.starts_with("tls://");
  const std::size_t scheme = url.find("://");
  if (!server.encrypted && !url.starts_with("nats://")) {
    throw std::invalid_argument(Shown(url.substr(url.rfind('@') + 1)) +
                                ": expected nats://HOST:PORT or tls://HOST:PORT");
  }
  const std::size_t at = url.rfind('@');
  const std::size_t host = at == std::string::npos ? scheme + 3 : at + 1;
  server.endpoint = ParseEndpoint(url.substr(host));
  if (!insecure && !server.encrypted && !IsLoopback(server.endpoint.host)) {
    throw std::invalid_argument("nats://" + ToString(server.endpoint) +
                                ": without --insecure, expected a loopback address, because "
                                "plain text is sent; tls:// encrypts it");
  }
  return server;
}

std::string SubjectOf(std::string_view slave, std::string_view kind) {
  std::string name(slave);
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_') c = '-';
  }
  return std::string(kRoot) + (name.empty() ? "slave" : name) + "." + std::string(kind);
}

struct NatsConnection::Parts {
  // Reports a text. Failing attempts with the same text are reported once.
  void Tell(const std::string& text) {
    {
      const std::scoped_lock lock(mutex);
      if (std::exchange(last_news, text) == text) return;
    }
    on_news(text);
  }
  void Open();

  // The last callback about a connection.
  static void OnClosed(natsConnection* /*nc*/, void* closure) {
    auto* const parts = static_cast<Parts*>(closure);
    const std::scoped_lock lock(parts->mutex);
    --parts->running;
    parts->finished.notify_all();
  }
  static void OnError(natsConnection* nc, natsSubscription* /*of*/, natsStatus error,
                      void* closure) {
    static_cast<Parts*>(closure)->Tell(std::string("NATS: ") + natsStatus_GetText(error) +
                                       WordsOf(nc));
  }

  Endpoint endpoint;
  OnNews on_news;
  Owned<natsOptions> options;
  std::chrono::steady_clock::time_point due{};  // of the next attempt
  std::mutex mutex;                             // guards the next three members
  std::condition_variable finished;
  std::size_t running = 0;  // connections that wait for their last callback
  std::string last_news;    // the last reported text
  Owned<natsConnection> connection;
};

void NatsConnection::Parts::Open() {
  const auto now = std::chrono::steady_clock::now();
  if (now < due) return;
  due = now + kRetry;
  if (connection) {
    Tell("the connection to the NATS server at " + ToString(endpoint) + " ended" +
         WordsOf(connection.get()) + "; trying again");
  }
  connection.reset();
  natsConnection* made = nullptr;
  const natsStatus status = natsConnection_Connect(&made, options.get());
  if (status != NATS_OK) {
    const char* const last = nats_GetLastError(nullptr);
    const std::string_view why = last != nullptr && *last != 0 ? last : natsStatus_GetText(status);
    Tell("no connection to the NATS server at " + ToString(endpoint) + WordsOf(why) +
         "; trying again");
    return;
  }
  connection.reset(made);
  {
    const std::scoped_lock lock(mutex);
    ++running;
  }
  Tell("connected to the NATS server at " + ToString(endpoint));
}

NatsConnection::NatsConnection(const NatsServer& server, const std::string& name, OnNews on_news)
    : parts_(std::make_unique<Parts>()) {
  parts_->endpoint = server.endpoint;
  parts_->on_news = std::move(on_news);
  natsOptions* options = nullptr;
  Check(natsOptions_Create(&options), "NATS");
  parts_->options.reset(options);
  Check(natsOptions_SetURL(options, server.url.c_str()), "the URL of the NATS server");
  if (server.encrypted) Check(natsOptions_SetSecure(options, true), "TLS");
  if (server.encrypted && !server.tls.empty()) {
    const std::string ca = server.tls / "ca.pem", cert = server.tls / "cert.pem",
                      key = server.tls / "key.pem";
    Check(natsOptions_LoadCATrustedCertificates(options, ca.c_str()), ca);
    Check(natsOptions_LoadCertificatesChain(options, cert.c_str(), key.c_str()), cert + ", " + key);
  }
  natsOptions_SetName(options, WithoutQuotes(name).c_str());
  natsOptions_SetTimeout(options, kConnectMs);
  natsOptions_SetWriteDeadline(options, kWriteMs);
  natsOptions_SetPingInterval(options, kPingMs);
  natsOptions_SetMaxPingsOut(options, kPingsOut);
  // The library's reconnection is off: it would buffer messages, and would give up after a rejected
  // password or certificate.
  natsOptions_SetAllowReconnect(options, false);
  natsOptions_SetErrorHandler(options, Parts::OnError, parts_.get());
  natsOptions_SetClosedCB(options, Parts::OnClosed, parts_.get());
}

// Callbacks use the parts until the last one. If it never arrives, the parts are not destroyed.
NatsConnection::~NatsConnection() {
  if (parts_->connection) natsConnection_Close(parts_->connection.get());
  std::unique_lock lock(parts_->mutex);
  const bool is_over =
      parts_->finished.wait_for(lock, kCloseWait, [this] { return parts_->running == 0; });
  lock.unlock();
  if (!is_over) static_cast<void>(parts_.release());
}

bool NatsConnection::Connected() {
  const auto is_connected = [this] {
    return parts_->connection &&
           natsConnection_Status(parts_->connection.get()) == NATS_CONN_STATUS_CONNECTED;
  };
  if (!is_connected()) parts_->Open();
  return is_connected();
}

bool NatsConnection::Publish(const std::string& subject, std::string_view bytes) {
  natsConnection* const connection = parts_->connection.get();
  if (connection == nullptr) return false;
  const natsStatus status = natsConnection_Publish(connection, subject.c_str(), bytes.data(),
                                                   static_cast<int>(bytes.size()));
  if (status == NATS_MAX_PAYLOAD) {
    parts_->Tell(Formatted(
        "%s is not published: a message exceeds %lld bytes, max_payload of the "
        "server",
        subject.c_str(), static_cast<long long>(natsConnection_GetMaxPayload(connection))));
  }
  return status == NATS_OK;
}

bool NatsConnection::Confirm() {
  return Connected() &&
         natsConnection_FlushTimeout(parts_->connection.get(), kConfirmMs) == NATS_OK;
}

}  // namespace palpate
