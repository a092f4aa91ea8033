// The simulated site of a scene with two cameras: a membrane under a large-strain law on a mesh of
// its own, or a textured target on its path. It shows itself through pictures only.
#pragma once

#include <memory>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "shared/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

struct StereoPictures {
  cv::Mat left, right;  // 8 bit grey
};

// Frame S.
struct MembraneTruth {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // of the tool [m]
  bool in_contact = false;
  Eigen::Vector3d force{0, 0, 0};  // of the object on the tool [N]
  double depth = 0;                // of the membrane under the tool's centre [m]
};

class StereoSite {
 public:
  // Throws std::invalid_argument naming the key where the scene cannot be simulated.
  explicit StereoSite(const Scene& scene);
  ~StereoSite();

  // The manipulator carries the tool here. Thread-safe, short.
  void MoveTool(const Eigen::Vector3d& p_S_tip);
  [[nodiscard]] MembraneTruth truth() const;
  // True displacement of the membrane's point that rests at p_O [m], frame O. For reports.
  [[nodiscard]] Eigen::Vector3d TrueDisplacement(const Eigen::Vector2d& p_O) const;
  // Both cameras at once, noise, blur and light as the scene's `site` says. One thread; the same
  // calls in the same order give the same pictures.
  StereoPictures TakePictures();
  // The pair as it really is.
  [[nodiscard]] const StereoRig& rig() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace palpate
