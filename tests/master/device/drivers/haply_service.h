// The stand-in for the Haply service as a process, and its control.
#pragma once

#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/master/device/drivers/driver_bench.h"
#include "tests/support/paths.h"

namespace palpate {

class HaplyService {
 public:
  // `port` 0: any. Throws std::runtime_error where it does not start.
  explicit HaplyService(const std::string& api, int port = 0)
      : path_(testing::TempDir() + "haply-" + std::to_string(getpid()) + ".sock") {
    const std::string script = SourcePath("/tests/master/device/fakes/haply_service.py");
    const std::string wanted = std::to_string(port);
    int out[2];
    if (pipe(out) != 0) throw std::runtime_error("pipe");
    unlink(path_.c_str());
    process_ = fork();
    if (process_ == 0) {
      dup2(out[1], STDOUT_FILENO);
      execl("/usr/bin/python3", "python3", script.c_str(), "--port", wanted.c_str(), "--api",
            api.c_str(), "--control", path_.c_str(), nullptr);
      _exit(127);
    }
    close(out[1]);
    std::FILE* printed = fdopen(out[0], "r");
    const bool listens = std::fscanf(printed, "listening on %d", &port_) == 1;
    std::fclose(printed);
    if (!listens) throw std::runtime_error("the stand-in for the Haply service does not start");
    Connect();
  }
  ~HaplyService() {
    close(control_);
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
    unlink(path_.c_str());
  }
  HaplyService(const HaplyService&) = delete;
  HaplyService& operator=(const HaplyService&) = delete;

  [[nodiscard]] std::uint16_t port() const { return static_cast<std::uint16_t>(port_); }
  // The answer to one line, see haply_service.py.
  std::string Ask(const std::string& line) const {
    const std::string text = line + "\n";
    if (write(control_, text.data(), text.size()) < 0) return "error: not written";
    std::string answer;
    for (char c = 0; read(control_, &c, 1) == 1 && c != '\n';) answer += c;
    return answer;
  }

 private:
  void Connect() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof(address.sun_path) - 1);
    control_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(control_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("the control of the stand-in does not answer");
    }
  }

  std::string path_;
  pid_t process_ = 0;
  int port_ = 0, control_ = -1;
};

// The service's hand follows `press` from its tick `first` on.
inline void FollowPress(const HaplyService& service, const std::vector<PressTick>& press,
                        std::size_t first) {
  const std::string file = testing::TempDir() + "palpate-haply-press.csv";
  std::ofstream csv(file);
  csv << "time_s,x,y,z\n";
  for (std::size_t i = first; i < press.size(); ++i) {
    const Eigen::Vector3d& p = press[i].p_M;
    csv << kBenchTick * static_cast<double>(i - first + 1) << ',' << p.x() << ',' << -p.z() << ','
        << p.y() << '\n';
  }
  csv.close();
  if (service.Ask("follow " + file) != "ok") throw std::runtime_error(file + " is not followed");
}

}  // namespace palpate
