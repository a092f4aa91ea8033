// Control by lines of text, from the environment and through a socket: see fakes.h.
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

using Eigen::Vector3d;

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

std::string Numbers(const Vector3d& a) {
  std::ostringstream out;
  out.precision(17);
  out << a.x() << ' ' << a.y() << ' ' << a.z();
  return out.str();
}

}  // namespace

std::string Core::Command(const std::string& line) {
  std::istringstream in(line);
  std::string verb, name;
  in >> verb;
  double x = 0, y = 0, z = 0;
  int a = 0, b = 0;
  if (verb == "set" && in >> name && in >> std::ws) {
    std::string value;
    std::getline(in, value);
    return SetOption(name, value) ? "ok" : "error: no such option or value: " + line;
  }
  if (verb == "follow" && in >> name) {
    const std::vector<FakeKnot> read = ReadKnots(name);
    std::string word;
    in >> word;
    fake_follow(read.data(), static_cast<int>(read.size()), word == "repeat");
    return read.empty() ? "error: no knots in " + name : "ok";
  }
  if (verb == "calls" && in >> name) return std::to_string(fake_calls(name.c_str()));
  if (verb == "error" && in >> name >> a >> b) {
    fake_set_error(name == "any" ? "" : name.c_str(), a, b);
  } else if (verb == "place" && in >> x >> y >> z) {
    fake_place(x, y, z);
  } else if (verb == "turn" && in >> x >> y >> z) {
    fake_turn(x, y, z);
  } else if (verb == "release") {
    fake_follow(nullptr, 0, 0);
  } else if (verb == "press" && in >> a >> b) {
    if (!(in >> x)) x = 0;
    fake_press(a, b, x);
  } else if (verb == "unplug") {
    fake_unplug();
  } else if (verb == "replug") {
    fake_replug();
  } else if (verb == "freeze" && in >> a) {
    fake_freeze(a);
  } else if (verb == "clock" && in >> x) {
    fake_set_clock(x);
  } else if (verb == "step" && in >> x) {
    fake_step(x);
  } else if (verb == "reset") {
    fake_reset();
  } else if (verb == "force") {
    double f[3];
    const int on = fake_last_force(f);
    return Numbers(Vector3d(f)) + ' ' + std::to_string(on);
  } else if (verb == "handle") {
    double place[3], speed[3];
    fake_get_handle(place, speed);
    return Numbers(Vector3d(place)) + ' ' + Numbers(Vector3d(speed));
  } else {
    return "error: not understood: " + line;
  }
  return "ok";
}

Start::Start(Core& core, const char* name) {
  core.Reset();
  const std::string prefix = std::string("PALPATE_FAKE_") + name;
  if (const char* commands = std::getenv((prefix + "_COMMANDS").c_str())) {
    std::istringstream lines(commands);
    for (std::string line; std::getline(lines, line, ';');) core.Command(line);
  }
  const char* path = std::getenv((prefix + "_CONTROL").c_str());
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

// One client at a time; the first that connects after another has left is served next.
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
