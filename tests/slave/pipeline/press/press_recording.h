// The recorded press on an air-filled membrane: depth images and wrench.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "slave/vision/depth/depth_points.h"
#include "tests/support/paths.h"

namespace palpate {

struct RecordedPress {
  struct Row {
    Eigen::Vector3d force{0, 0, 0};  // change against frames 40 to 58, the wrench's frame [N]
  };
  struct Frame {
    int number = 0;
    std::vector<SurfacePoint> points;
  };
  std::vector<Row> rows;      // one per frame of the recording
  std::vector<Frame> frames;  // frames after the rest frame that have a depth image
  double rest_scatter = 0;  // rms of (displacement along the normal / its sigma) in frames up to 58
  double rest_rms = 0;      // the same, not divided [m]
};

inline std::filesystem::path RecordedPressFolder() {
  return SourcePath("/../shared/data/membrane_press_rgbd");
}
// Parameters from the folder's description; 0.08 mm is the noise of single depths at rest.
DepthPoints::Params RecordedPressCamera();
RecordedPress ReadRecordedPress(const std::filesystem::path& folder);

}  // namespace palpate
