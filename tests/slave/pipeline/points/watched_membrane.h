// A membrane with dots for tests of a stereo pair: its images come from the closed form
// of a thin plate, not from any model of the product.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "slave/capture/frame_source.h"

namespace palpate::testing_fakes {

// The membrane of paper C, 3.5 mm thick (1 mm deep under 4 N), in front of a simulated pair of
// cameras. `points` and `model` are the keys and values of these maps of the scene.
Scene WatchedMembraneScene(const std::string& points = "track: dots",
                           const std::string& model = "kind: plate");

// Down displacement [m] at p_O of that plate under `force` [N] at p_O_load: paper C, eqs. (1) and
// (2), as restored in terms of R1 and R2.
double PlateDeflection(double force, const Eigen::Vector2d& p_O_load, const Eigen::Vector2d& p_O);

struct Press {
  double force = 0;  // of the tool on the membrane, downward [N]
  Eigen::Vector2d p_O{0, 0};
  bool covered = false;  // an object covers the left camera
};

// Draws the array of 31 dots under a press.
class DotPairs {
 public:
  StereoPair Draw(const Press& press, std::uint64_t seed = 1) const;
};

// The scene that a test's source shows, a pair every 5 ms.
class MembraneEnvironment {
 public:
  void Show(const Press& press);  // also ends FallSilent
  void FallSilent();              // no image from now on
  void End();
  void Break();

 private:
  friend class MembraneSource;
  std::mutex mutex_;
  std::vector<StereoPair> pairs_;  // shown in turn
  std::uint64_t drawn_ = 0;        // number of drawn pairs; each has its own noise
  bool silent_ = false, ended_ = false, broken_ = false;
};

class MembraneSource final : public StereoSource {
 public:
  explicit MembraneSource(std::shared_ptr<MembraneEnvironment> environment)
      : environment_(std::move(environment)) {}
  std::optional<StereoPair> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override { return "a fake"; }

 private:
  std::shared_ptr<MembraneEnvironment> environment_;
  std::uint64_t sequence_ = 0;
};

}  // namespace palpate::testing_fakes
