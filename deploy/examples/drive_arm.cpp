// Drives the slave's manipulator: drive_arm HOST:PORT [SECONDS] [TLS_FOLDER]. In place of a real
// arm it moves a point, which follows its target with a lag. The scene needs `manipulator: {source:
// stream}`. Prints the number of reports and targets. Exit code 0: both were exchanged; 1: not.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include <palpate/client.h>

class LaggingPoint : public palpate::Arm {
 public:
  explicit LaggingPoint(const palpate::Vector& home) : tip_(home), target_(home) {}

  palpate::ArmReading Measure(double dt) override {
    const double share = 1 - std::exp(-dt / 0.003);  // time constant 3 ms
    palpate::ArmReading reading;
    for (std::size_t i = 0; i < 3; ++i) tip_[i] += share * (target_[i] - tip_[i]);
    reading.tip = tip_;
    return reading;
  }
  void Go(const palpate::Vector& tip, const palpate::Vector& /*velocity*/) override {
    target_ = tip;
  }
  void Hold() override { target_ = tip_; }

 private:
  palpate::Vector tip_, target_;
};

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: drive_arm HOST:PORT [SECONDS] [TLS_FOLDER]\n");
    return 2;
  }
  const palpate::Slave slave(argv[1], argc > 3 ? argv[3] : "");
  const auto can = slave.Scene().capabilities();
  const auto low = palpate::ToVector(can.workspace_min()),
             high = palpate::ToVector(can.workspace_max());
  LaggingPoint arm({(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2});
  const auto done = slave.Drive(arm, 250, argc > 2 ? std::atof(argv[2]) : 1, "point");
  std::printf("%lu reports, %lu targets\n", done.reports, done.targets);
  return done.reports > 0 && done.targets > 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
