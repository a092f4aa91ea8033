// Models with answers, cost and errors that a test sets, and a clock that only they advance.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "slave/study/study.h"

namespace palpate::study::fake {

// The force is stiffness times depth, against the displacement.
class Spring final : public DeformationModel {
 public:
  Spring(double stiffness, double update_s, double* clock)
      : stiffness_(stiffness), update_s_(update_s), clock_(*clock) {
    info_.kind = "spring";
  }
  [[nodiscard]] std::string_view failure() const override { return "spring broke"; }

 private:
  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      responses[i].force_O = stiffness_ * contacts[i].prescribed_O;
      responses[i].validity = std::isfinite(stiffness_) ? Validity::kValid : Validity::kFailed;
    }
    clock_ += update_s_;
  }
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override { u_O->clear(); }

  double stiffness_, update_s_;
  double& clock_;
};

struct Scenario {
  double clock = 1000;  // [s]
  int made = 0;
  // Seconds of precompute; by default a microsecond per element, cubed.
  std::function<double(const Scene&)> precompute = [](const Scene& scene) {
    return 1e-9 * std::pow(scene.model.elements, 3);
  };
  // First order in the element size, whatever the order requested.
  std::function<double(const Scene&)> stiffness = [](const Scene& scene) {
    return 100 * (1 - 3.0 / scene.model.elements);
  };
  std::function<void(Progress*)> while_making = [](Progress*) {};

  ModelFactory Make() {
    return {[this](const Scene& scene, const ObjectMesh&, Progress* progress) {
              ++made;
              while_making(progress);
              clock += precompute(scene);
              return std::make_unique<Spring>(stiffness(scene), 1e-6, &clock);
            },
            [this] { return clock; }};
  }
};

// A square of 60 mm, pressed by a tool of 4 mm at the centre of its top. Its back faces the camera,
// a pose for which no finite-element reference is solved besides the models.
inline Scene Square() {
  Scene scene;
  scene.name = "square <&> \"quoted\", with a comma";
  scene.object.geometry = RectangleGeometry{0.06, 0.06, 0.01};
  scene.object.material.young_modulus = 1e5;
  scene.object.material.poisson_ratio = 0.4;
  scene.object.fixed = {{FixedSide{"bottom"}}, {FixedSide{"left"}}};
  scene.object.X_SO.linear().diagonal() << -1, 1, -1;
  scene.object.X_SO.translation() << 0.06, 0, 0;
  scene.tool = Tool{.width = 0.004, .depth = std::numeric_limits<double>::infinity()};
  scene.model.contact = ContactLaw::kFrictionless;
  scene.model.elements = 60;
  scene.manipulator.home = {0.03, 0.07, 0};
  return scene;
}

}  // namespace palpate::study::fake
