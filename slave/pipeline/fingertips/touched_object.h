// The object under all fingertips: their contacts with it, and how it deforms under them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/validity.h"
#include "slave/pipeline/fingertips/finger_contact.h"
#include "slave/pipeline/fingertips/tactile_body.h"

namespace palpate {

// Without a body (unknown poses of the fingertips) there is no contact and no deformation.
class TouchedObject {
 public:
  explicit TouchedObject(const Scene& scene);

  // Activates another body: it is at rest, and the next sample finds its contacts again.
  void Adopt(std::unique_ptr<TactileBody> body) noexcept;
  void Reset() noexcept;
  // Returns the depth of fingertip `i` below the surface at rest [m]; nullopt: without a body.
  [[nodiscard]] std::optional<double> DepthOf(const Eigen::Isometry3d& X_SF) const noexcept;
  // The next sample of fingertip `i`; `X_SF` null: its pose is unknown.
  void Touch(std::size_t i, const Eigen::Isometry3d* X_SF, const FingerTouch& touch) noexcept;
  // Computes the deformation after Touch of all fingertips. Never throws; allocation-free once
  // every contact point was visited (contacts over an area: while they stay).
  void Deform() noexcept;

  [[nodiscard]] TactileBody* body() const { return body_.get(); }
  [[nodiscard]] const Eigen::Isometry3d& X_SO() const { return X_SO_; }
  [[nodiscard]] const FingerContact& contact(int i) const {
    return fingers_[static_cast<std::size_t>(i)];
  }
  // Loads on the object since the last sample: contacts and the model's responses, per fingertip.
  [[nodiscard]] std::span<const Contact> contacts() const { return contacts_; }
  // Returns the model's response under fingertip `i`; null: no load.
  [[nodiscard]] const ContactResponse* ResponseOf(std::size_t i) const noexcept;
  // State of the deformation.
  [[nodiscard]] Validity validity() const { return validity_; }
  // Why it is extrapolated, one clause with static lifetime; may be empty.
  [[nodiscard]] std::string_view flag_reason() const { return flag_reason_; }
  // Nodes of the surface as they are deformed now, frame S [m]; empty without a body. O(N).
  [[nodiscard]] std::vector<Eigen::Vector3d> DeformedNodes() const;

 private:
  [[nodiscard]] bool Respond() noexcept;
  void SeparateHeld() noexcept;

  Eigen::Isometry3d X_SO_;
  double radius_;  // of the fingertips [m]
  std::unique_ptr<TactileBody> body_;
  std::vector<FingerContact> fingers_;
  std::vector<Contact> contacts_;  // of the fingertips in acting_
  std::vector<std::size_t> acting_;
  Solution solution_;
  bool at_rest_ = true;
  Validity validity_ = Validity::kValid;
  std::string_view flag_reason_;
};

}  // namespace palpate
