// The simulated slave site: a world of its own, with a finer and independent solution of the
// pressed body, that shows itself only through camera pictures. Its true force is for reports,
// never for an estimator.
#pragma once

#include <memory>
#include <mutex>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "shared/scene/scene.h"

namespace palpate {

// What really happens at the site at this moment. Frame S.
struct SiteTruth {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // true tip [m]
  Eigen::Vector3d force{0, 0, 0};    // of the object on the tool [N]
  double depth = 0;                  // true indentation along the surface normal [m]; 0: no contact
  bool in_contact = false;
};

class SimulatedSite {
 public:
  // Builds the finer solution's mesh. Throws std::invalid_argument where the scene cannot be
  // simulated (no tool width, outline from an image).
  explicit SimulatedSite(const Scene& scene);
  ~SimulatedSite();

  // The manipulator carries the tool here. Thread-safe; microseconds, except on approach to a new
  // place, where the solution for it is computed (tens of milliseconds).
  void MoveTool(const Eigen::Vector3d& p_S_tip);
  // Thread-safe.
  [[nodiscard]] SiteTruth truth() const;
  // Takes a picture of the world as it is now: 8 bit grey. Thread-safe against MoveTool; call from
  // one thread.
  cv::Mat TakePicture();

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace palpate
