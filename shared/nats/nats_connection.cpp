#include "shared/nats/nats_connection.h"

#include <cctype>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <nats/nats.h>
#include <nlohmann/json.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::string_view kRoot = "palpate.";
constexpr int kConnectMs = 1000, kConfirmMs = 400, kWriteMs = 500;
// An attempt each quarter of a second: observers are back soon after the server.
constexpr int kRetryMs = 200, kRetryJitterMs = 50;
constexpr int kPingMs = 2000, kPingsOut = 2;  // a server that says nothing for 4 s is given up
constexpr std::chrono::seconds kCloseWait(2);
constexpr std::size_t kLongestReason = 200;

struct Free {
  void operator()(natsOptions* options) const { natsOptions_Destroy(options); }
  void operator()(natsConnection* connection) const { natsConnection_Destroy(connection); }
  void operator()(natsSubscription* subscription) const { natsSubscription_Destroy(subscription); }
  void operator()(natsMsg* message) const { natsMsg_Destroy(message); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

void Check(natsStatus status, const std::string& what) {
  if (status == NATS_OK) return;
  throw std::invalid_argument(what + ": " + natsStatus_GetText(status));
}

// `observer NAME at HOST was cut off: Slow Consumer (Write Deadline)`; empty: another end.
std::string SlowClientIn(std::string_view advisory) {
  const auto json = nlohmann::json::parse(advisory, nullptr, false);
  if (!json.is_object()) return {};
  const auto word = [](const nlohmann::json& from, const char* key) {
    const auto found = from.find(key);
    return found != from.end() && found->is_string() ? Presentable(found->get<std::string>(), 80)
                                                     : std::string();
  };
  const std::string reason = word(json, "reason");
  if (!reason.starts_with("Slow Consumer")) return {};
  const auto client = json.value("client", nlohmann::json::object());
  if (!client.is_object()) return {};
  const std::string name = word(client, "name");
  return "the NATS server cut off " + (name.empty() ? "a client" : name) + " at " +
         word(client, "host") + ": " + reason;
}

}  // namespace

NatsServer ParseNatsServer(const std::string& url, bool insecure,
                           const std::filesystem::path& tls) {
  NatsServer server{.url = url, .tls = tls};
  server.encrypted = url.starts_with("tls://");
  const std::size_t scheme = url.find("://");
  if (!server.encrypted && !url.starts_with("nats://")) {
    throw std::invalid_argument(Shown(url.substr(url.rfind('@') + 1)) +
                                ": accepted is nats://HOST:PORT or tls://HOST:PORT");
  }
  const std::size_t at = url.rfind('@');
  const std::size_t host = at == std::string::npos ? scheme + 3 : at + 1;
  server.endpoint = ParseEndpoint(url.substr(host));
  if (!insecure && !server.encrypted && !IsLoopback(server.endpoint.host)) {
    throw std::invalid_argument("nats://" + ToString(server.endpoint) +
                                ": accepted without --insecure is a loopback address, because "
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

SubjectParts PartsOf(std::string_view subject) {
  const std::size_t dot = subject.rfind('.');
  if (!subject.starts_with(kRoot) || dot <= kRoot.size()) return {};
  return {subject.substr(kRoot.size(), dot - kRoot.size()), subject.substr(dot + 1)};
}

struct NatsConnection::Parts {
  struct Reader {
    OnMessage on_message;
    Owned<natsSubscription> subscription;
  };

  // One failing attempt after the other says the same: told once.
  void Tell(const std::string& text) {
    {
      const std::scoped_lock lock(mutex);
      if (std::exchange(told, text) == text) return;
    }
    on_news(text);
  }
  void Finish(std::size_t Parts::*count) {
    const std::scoped_lock lock(mutex);
    ++(this->*count);
    finished.notify_all();
  }
  [[nodiscard]] std::string place() const { return ToString(endpoint); }

  static void OnConnected(natsConnection* /*nc*/, void* closure) {
    auto* const parts = static_cast<Parts*>(closure);
    parts->Tell("connected to the NATS server at " + parts->place());
  }
  static void OnDisconnected(natsConnection* nc, void* closure) {
    auto* const parts = static_cast<Parts*>(closure);
    const char* why = nullptr;
    natsConnection_GetLastError(nc, &why);
    parts->Tell("the connection to the NATS server at " + parts->place() + " ended" +
                (why != nullptr && *why != 0 ? ": " + Presentable(why, kLongestReason) : "") +
                "; trying again");
  }
  static void OnError(natsConnection* nc, natsSubscription* /*of*/, natsStatus error,
                      void* closure) {
    auto* const parts = static_cast<Parts*>(closure);
    const char* why = nullptr;
    natsConnection_GetLastError(nc, &why);
    parts->Tell(std::string("NATS: ") + natsStatus_GetText(error) +
                (why != nullptr && *why != 0 ? ": " + Presentable(why, kLongestReason) : ""));
  }
  // The last callback about the connection, and the last one about a subscription.
  static void OnClosed(natsConnection* /*nc*/, void* closure) {
    static_cast<Parts*>(closure)->Finish(&Parts::is_closed);
  }
  static void OnComplete(void* closure) { static_cast<Parts*>(closure)->Finish(&Parts::completed); }
  static void OnMessageOf(natsConnection* /*nc*/, natsSubscription* /*of*/, natsMsg* message,
                          void* closure) {
    const Owned<natsMsg> owned(message);
    static_cast<Reader*>(closure)->on_message(
        natsMsg_GetSubject(message),
        {natsMsg_GetData(message), static_cast<std::size_t>(natsMsg_GetDataLength(message))});
  }

  Endpoint endpoint;
  OnNews on_news;
  std::mutex mutex;  // guards the next four members
  std::condition_variable finished;
  std::size_t is_closed = 0, completed = 0;  // callbacks that came to their end
  std::string told;                          // the last news
  std::deque<Reader> readers;                // stay where they are
  Owned<natsConnection> connection;
};

NatsConnection::NatsConnection(const NatsServer& server, const std::string& name, OnNews on_news)
    : parts_(std::make_unique<Parts>()) {
  Parts* const parts = parts_.get();
  parts->endpoint = server.endpoint;
  parts->on_news = std::move(on_news);
  natsOptions* made = nullptr;
  Check(natsOptions_Create(&made), "NATS");
  const Owned<natsOptions> options(made);
  Check(natsOptions_SetURL(made, server.url.c_str()), "the URL of the NATS server");
  if (server.encrypted) Check(natsOptions_SetSecure(made, true), "TLS");
  if (server.encrypted && !server.tls.empty()) {
    const std::string ca = server.tls / "ca.pem", cert = server.tls / "cert.pem",
                      key = server.tls / "key.pem";
    Check(natsOptions_LoadCATrustedCertificates(made, ca.c_str()), ca);
    Check(natsOptions_LoadCertificatesChain(made, cert.c_str(), key.c_str()), cert + ", " + key);
    Check(natsOptions_SetExpectedHostname(made, server.endpoint.host.c_str()), "TLS");
  }
  natsOptions_SetName(made, name.c_str());
  natsOptions_SetTimeout(made, kConnectMs);
  natsOptions_SetWriteDeadline(made, kWriteMs);
  natsOptions_SetPingInterval(made, kPingMs);
  natsOptions_SetMaxPingsOut(made, kPingsOut);
  natsOptions_SetMaxReconnect(made, -1);
  natsOptions_SetReconnectWait(made, kRetryMs);
  natsOptions_SetReconnectJitter(made, kRetryJitterMs, kRetryJitterMs);
  natsOptions_SetRetryOnFailedConnect(made, true, Parts::OnConnected, parts);
  natsOptions_SetReconnectedCB(made, Parts::OnConnected, parts);
  natsOptions_SetDisconnectedCB(made, Parts::OnDisconnected, parts);
  natsOptions_SetErrorHandler(made, Parts::OnError, parts);
  natsOptions_SetClosedCB(made, Parts::OnClosed, parts);
  natsConnection* connection = nullptr;
  const natsStatus status = natsConnection_Connect(&connection, made);
  parts->connection.reset(connection);
  if (status == NATS_OK) {
    Parts::OnConnected(connection, parts);
  } else if (status == NATS_NOT_YET_CONNECTED) {
    parts->Tell("no connection to the NATS server at " + parts->place() + "; trying again");
  } else {
    Check(status, "NATS");
  }
}

// Callbacks use the parts until their end. Should one never come, the parts stay.
NatsConnection::~NatsConnection() {
  natsConnection_Close(parts_->connection.get());
  std::unique_lock lock(parts_->mutex);
  const bool is_over = parts_->finished.wait_for(lock, kCloseWait, [this] {
    return parts_->is_closed > 0 && parts_->completed == parts_->readers.size();
  });
  lock.unlock();
  if (!is_over) static_cast<void>(parts_.release());
}

bool NatsConnection::connected() const {
  return natsConnection_Status(parts_->connection.get()) == NATS_CONN_STATUS_CONNECTED;
}

void NatsConnection::Subscribe(const std::string& subject, OnMessage on_message) {
  Parts::Reader& reader = parts_->readers.emplace_back();
  reader.on_message = std::move(on_message);
  natsSubscription* subscription = nullptr;
  Check(natsConnection_Subscribe(&subscription, parts_->connection.get(), subject.c_str(),
                                 Parts::OnMessageOf, &reader),
        subject);
  reader.subscription.reset(subscription);
  natsSubscription_SetOnCompleteCB(subscription, Parts::OnComplete, parts_.get());
}

void NatsConnection::ReportSlowClients() {
  Subscribe("$SYS.ACCOUNT.*.DISCONNECT",
            [parts = parts_.get()](std::string_view /*subject*/, std::string_view bytes) {
              const std::string text = SlowClientIn(bytes);
              if (!text.empty()) parts->on_news(text);
            });
}

bool NatsConnection::Publish(const std::string& subject, std::string_view bytes) {
  natsConnection* const connection = parts_->connection.get();
  if (!connected()) return false;
  const natsStatus status = natsConnection_Publish(connection, subject.c_str(), bytes.data(),
                                                   static_cast<int>(bytes.size()));
  if (status == NATS_MAX_PAYLOAD) {
    parts_->Tell(Formatted(
        "%s is not published: a message exceeds %lld bytes, max_payload of the server",
        subject.c_str(), static_cast<long long>(natsConnection_GetMaxPayload(connection))));
  }
  return status == NATS_OK;
}

bool NatsConnection::Confirm() {
  return connected() &&
         natsConnection_FlushTimeout(parts_->connection.get(), kConfirmMs) == NATS_OK;
}

}  // namespace palpate
