// A measured cloud against the estimated shape (paper B, IV.C, figures 11 and 12).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"
#include "slave/study/clouds/object_choice.h"
#include "slave/study/clouds/pcd_file.h"
#include "slave/study/clouds/segmentation.h"
#include "slave/study/shape/shape_score.h"
#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate::study {

// The shape of a scene's object according to its model.
struct EstimatedShape {
  SurfaceMesh rest_S, estimate_S;   // same nodes and triangles [m]
  std::string state;                // origin of the estimate, as text
  std::vector<Occluder> fingers_S;  // fingertips that are in the camera's view
};

struct MeasuredQuestion {
  std::string scene;                  // name of the scene
  std::string file;                   // of the cloud
  PcdCloud measured;                  // frame D of the camera
  std::optional<DepthCamera> camera;  // absent: no score
  EstimatedShape shape;
  Segmenting segmenting = Segmenting::kSurfaces;
  ObjectHint hint;     // the object's position in the scene is added
  double leaf = 0.01;  // [m]
};

struct MeasuredAnswer {
  Segmentation segmentation;
  ObjectChoice choice;
  PointCloud object;     // frame D
  PointCloud simulated;  // points of the estimate that the camera would see, frame D
  ShapeScore score;
};

// No region in the cloud, or no part of the estimate in view: `score.octree` is NaN. Throws as
// ChooseObject.
MeasuredAnswer Evaluate(const MeasuredQuestion& question);

// Writes report.json, object.pcd, segmentation.pcd (frame D; `label` is 1 + region, 0: none) and
// simulated.pcd (frame D). False: cannot be written.
bool WriteMeasured(const MeasuredQuestion& question, const MeasuredAnswer& answer,
                   const std::filesystem::path& folder);

}  // namespace palpate::study
