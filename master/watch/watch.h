// `palpate-master watch`: a table of the slaves that publish on a NATS server.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace palpate {

struct WatchOptions {
  std::string url;            // of the NATS server
  std::filesystem::path tls;  // folder of our certificate; empty: none
  bool insecure = false;
  double duration = 0;  // [s]; 0: until stopped
  bool json = false;    // lines of JSON instead of a table
  std::string name;     // name of this client at the server
};

// Shows the table each second until `stopped` or the end of the duration; on a terminal it replaces
// the last one. The news of the connection are shown below it, or go to standard error. Returns the
// exit code: 1 if there never was a connection. Throws std::invalid_argument: unusable options.
int RunWatch(const WatchOptions& options, const std::function<bool()>& stopped);

}  // namespace palpate
