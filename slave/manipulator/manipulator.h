// Moves the tool. Pipeline and service use only this interface; each kind of manipulator implements
// it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/clock.h"
#include "slave/manipulator/driven_arm.h"
#include "slave/scene/scene.h"

namespace palpate {

class StreamedManipulator;

class Manipulator {
 public:
  virtual ~Manipulator() = default;
  Manipulator() = default;
  Manipulator(const Manipulator&) = delete;
  Manipulator& operator=(const Manipulator&) = delete;

  // Sets the target of the tip, S [m]. Thread-safe; the latest target is used. A target outside the
  // workspace is replaced by the nearest point inside. Returns false and ignores a target that is
  // not finite.
  virtual bool Command(const Eigen::Vector3d& p_S_target) noexcept = 0;
  // Stops at the present position. Thread-safe.
  virtual void Hold() noexcept = 0;
  // Emergency stop: stops, with brakes if there are any, until released. Thread-safe.
  virtual void Stop() noexcept { Hold(); }
  // Returns the tip position from the encoders, S [m]. Thread-safe.
  [[nodiscard]] virtual Eigen::Vector3d Tip() const noexcept = 0;
  // Sets the target of the tool's rotation in S, while it follows a target of the tip. Thread-safe;
  // the latest target is used. Ignored without an orientation.
  virtual void Turn(const Eigen::Quaterniond& /*R_S_target*/) noexcept {}
  // The tool's rotation in S from the encoders; nullopt: it has none, or it is not measured.
  // Thread-safe.
  [[nodiscard]] virtual std::optional<Eigen::Quaterniond> Rotation() const noexcept {
    return std::nullopt;
  }
  // Returns the encoder reading at `t`, within about the last half second. An arm without a history
  // returns the present position.
  [[nodiscard]] virtual Eigen::Vector3d TipAt(Time /*t*/) const noexcept { return Tip(); }
  // Increases when earlier positions become invalid, because another driver may use another origin.
  // Thread-safe.
  [[nodiscard]] virtual std::uint32_t frame() const noexcept { return 0; }
  // Returns whether the workspace or a speed limit clipped the last target. Thread-safe.
  [[nodiscard]] virtual bool at_limit() const noexcept = 0;
  // Returns whether it moves a tool that images may show.
  [[nodiscard]] virtual bool carries_tool() const noexcept = 0;
  // Returns whether its readings belong to the samples, as in a recording.
  [[nodiscard]] virtual bool comes_with_samples() const noexcept { return false; }

  // The manipulator does not move the tool, or its position is unknown. It holds until a new
  // engagement. Thread-safe.
  [[nodiscard]] virtual bool is_faulty() const noexcept { return false; }
  // Health of a manipulator that a client drives; nullopt: it is part of the slave.
  [[nodiscard]] virtual std::optional<ArmHealth> health() const { return std::nullopt; }
  // Returns the force of the object on the tool, measured by a sensor of the manipulator, S [N]. No
  // estimator reads it. nullopt: no sensor. Thread-safe.
  [[nodiscard]] virtual std::optional<Eigen::Vector3d> measured_force() const noexcept {
    return std::nullopt;
  }
  // Returns this manipulator if a client drives it, else null.
  [[nodiscard]] virtual StreamedManipulator* driven() noexcept { return nullptr; }
};

// Creates the manipulator of the scene. Throws std::invalid_argument or std::runtime_error naming
// the key.
std::unique_ptr<Manipulator> MakeManipulator(const Scene& scene);

}  // namespace palpate
