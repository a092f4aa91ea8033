// A connection to a NATS server, which passes what a slave publishes to any number of observers.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "shared/link/loopback.h"

namespace palpate {

struct NatsServer {
  std::string url;  // may contain a password: never shown
  Endpoint endpoint;
  bool encrypted = false;
  std::filesystem::path tls;  // folder of our certificate; empty: the system's CAs, and none
};

// Parses `nats://[USER:PASSWORD@|TOKEN@]HOST:PORT`, or `tls://` for TLS, which uses the
// certificates of the folder `tls` if there is one. Throws std::invalid_argument with what is
// accepted: plain text beyond loopback only if `insecure`.
NatsServer ParseNatsServer(const std::string& url, bool insecure, const std::filesystem::path& tls);

// The subject of a kind of messages of a slave: `palpate.NAME.KIND`. Characters that are invalid in
// a subject become `-` in NAME.
std::string SubjectOf(std::string_view slave, std::string_view kind);

// Connects, and reconnects whenever the connection ends. Messages are not stored while there is no
// connection. All methods are called by one thread.
class NatsConnection {
 public:
  // May also be called by threads of the library.
  using OnNews = std::function<void(const std::string& text)>;

  // `name`: how the server calls this client in its log. `on_news` gets changes of the connection
  // in words. Throws std::invalid_argument: unusable certificates.
  NatsConnection(const NatsServer& server, const std::string& name, OnNews on_news);
  // Returns within two seconds; then no callback runs any more.
  ~NatsConnection();
  NatsConnection(const NatsConnection&) = delete;
  NatsConnection& operator=(const NatsConnection&) = delete;

  // Returns whether there is a connection. Without one it tries to connect, up to five times per
  // second; an attempt without an answer takes a second.
  bool Connected();
  // False: there is no connection, or the server accepts no message of this size.
  bool Publish(const std::string& subject, std::string_view bytes);
  // Returns whether the server has received everything that was published. Waits up to 0.4 s for
  // it.
  bool Confirm();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
