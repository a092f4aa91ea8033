// The driver of the Inverse3 with a fake Haply service, which is a separate process.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "master/device/haply/haply_device.h"
#include "tests/master/device/drivers/device_bench.h"
#include "tests/support/allocation_count.h"
#include "tests/support/eventually.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

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
  // Returns the answer to one line, see haply_service.py.
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

// A tick waits for its messages, however long they take. The force gate is open.
class HaplyBench final : public DeviceBench {
  // Returns the result of `call` and counts its allocations.
  template <class Call>
  auto Counted(const Call& call) {
    const long before = OwnAllocationCount();
    const auto result = call();
    allocations_ += OwnAllocationCount() - before;
    return result;
  }

  const Scratch scratch_;
  long allocations_ = 0;
  std::atomic<Time> now_{Time{std::chrono::hours(1)}};

 public:
  explicit HaplyBench(const std::string& api) : service(api) {
    service.Ask("clock 0");
    service.Ask("set gain 1");
  }

  void Open() override {
    Eventually([this] {  // a busy machine may keep the service from answering in time
      try {
        device = HaplyDevice::Open({service.port(), [this] { return now_.load(); }});
      } catch (const DeviceUnavailable&) {
        return false;
      }
      return true;
    });
    ASSERT_TRUE(device);
    device->LowerForceLimit(kForceLimit);
  }
  // Advances both clocks by a millisecond and waits for two answers of the service; the second has
  // the new time.
  DeviceReading Read() {
    service.Ask("step 0.001");
    now_ = now_.load() + std::chrono::milliseconds(1);
    DeviceReading reading = Counted([this] { return device->Read(now_); });
    int fresh = 0;
    EXPECT_TRUE(Eventually([&] {
      reading = Counted([this] { return device->Read(now_); });
      if (!reading.repeated) ++fresh;
      return fresh == 2;
    }));
    return reading;
  }
  DeviceReading Run(int ms, const Eigen::Vector3d& force) {
    DeviceReading reading;
    for (int i = 0; i < ms; ++i) {
      reading = Read();
      device->WriteWrench(force, {0, 0, 0});
    }
    return reading;
  }
  const TickRecord& Step() override {
    const DeviceReading reading = Read();
    rig.now = now_;
    rig.slave.Step(now_, &rig.commands, &rig.states);
    Counted([&] {
      device->WriteForce(rig.loop.Tick(reading, now_));
      return 0;
    });
    TickRecord drained;
    while (rig.records.Pop(&drained)) {
    }
    return rig.loop.record();
  }
  // The service's frame has z up and y away from the operator.
  [[nodiscard]] Eigen::Vector3d Made() const override {
    std::istringstream answer(service.Ask("force"));
    Eigen::Vector3d f(NAN, NAN, NAN);
    answer >> f.x() >> f.y() >> f.z();
    return {f.x(), f.z(), -f.y()};
  }
  void Follow(const std::vector<PressTick>& press) override {
    const std::string file = scratch_ / "press.csv";
    std::ofstream csv(file);
    csv << "time_s,x,y,z\n";
    for (std::size_t i = 0; i < press.size(); ++i) {
      const Eigen::Vector3d& p = press[i].p_M;
      csv << kBenchTick * static_cast<double>(i + 1) << ',' << p.x() << ',' << -p.z() << ','
          << p.y() << '\n';
    }
    csv.close();
    if (service.Ask("follow " + file) != "ok") throw std::runtime_error(file + " is not followed");
  }
  void Switch(bool is_closed) override { service.Ask(is_closed ? "press 0 1" : "press 0 0"); }
  void Unplug() override { service.Ask("unplug"); }
  void Replug() override { service.Ask("replug"); }
  // On the tick's thread: messages are for the driver's own.
  [[nodiscard]] long allocations() const override { return allocations_; }

  HaplyService service;
};

}  // namespace palpate
