// Control by lines of text through a socket: see fakes.h.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/master/device/fakes/fake_core.h"

namespace palpate::fakes {
namespace {

std::vector<FakeKnot> ReadKnots(const std::string& path) {
  std::ifstream file(path);
  std::vector<FakeKnot> knots;
  for (std::string line; std::getline(file, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream in(line);
    if (FakeKnot knot{}; in >> knot.t >> knot.x >> knot.y >> knot.z) knots.push_back(knot);
  }
  return knots;
}

}  // namespace

std::string Core::Command(const std::string& line) {
  std::istringstream in(line);
  std::string verb, file;
  int button = 0, down = 0;
  double after = 0;
  in >> verb;
  if (verb == "follow" && in >> file) {
    const std::vector<FakeKnot> read = ReadKnots(file);
    fake_follow(read.data(), static_cast<int>(read.size()));
    return read.empty() ? "error: no knots in " + file : "ok";
  }
  if (verb == "press" && in >> button >> down) {
    if (!(in >> after)) after = 0;
    fake_press(button, down, after);
    return "ok";
  }
  return "error: not understood: " + line;
}

Start::Start(Core& core, const char* name) {
  core.Reset();
  const char* path = std::getenv((std::string("PALPATE_FAKE_") + name + "_CONTROL").c_str());
  if (!path) return;
  path_ = path;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path, sizeof address.sun_path - 1);
  listening_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  unlink(path);
  if (bind(listening_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      listen(listening_, 4) != 0) {
    return;
  }
  server_ = std::jthread([this, &core] { Serve(core); });
}

Start::~Start() {
  if (listening_ < 0) return;
  shutdown(listening_, SHUT_RDWR);
  shutdown(client_, SHUT_RDWR);
  if (server_.joinable()) server_.join();
  close(listening_);
  unlink(path_.c_str());
}

// Serves one client at a time; after it disconnects, the next one is served.
void Start::Serve(Core& core) {
  for (int client; (client = accept(listening_, nullptr, nullptr)) >= 0; close(client)) {
    client_ = client;
    std::string text;
    char part[256];
    for (ssize_t size; (size = recv(client, part, sizeof part, 0)) > 0;) {
      text.append(part, static_cast<std::size_t>(size));
      for (std::size_t end; (end = text.find('\n')) != std::string::npos;) {
        const std::string reply = core.Command(text.substr(0, end)) + '\n';
        text.erase(0, end + 1);
        if (send(client, reply.data(), reply.size(), MSG_NOSIGNAL) < 0) break;
      }
    }
  }
}

}  // namespace palpate::fakes
