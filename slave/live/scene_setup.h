// Set-up of a scene while the slave runs.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slave/live/slave.h"
#include "slave/program/progress.h"
#include "slave/scene/scene_mistake.h"
#include "slave/vision/outline_finder.h"

namespace palpate {

// Text of a scene, and contents of the files that it names.
struct SceneProposal {
  std::string scene;
  std::map<std::string, std::string> files;  // by name, without a folder
};

struct ProposalReport {
  std::vector<SceneMistake> mistakes;  // empty: the scene can be used, and the rest is set
  std::string text;                    // the output of `check`
  SlaveDescription description;
  struct Contact {
    double depth = 0, force = 0;  // [m], [N]
    double largest_depth = 0;     // largest valid one [m]; 0: unknown
    double update = 0;            // 99th percentile of the model's update [s]
  };
  std::optional<Contact> contact;  // a typical one
};

// A checked and saved scene whose slave has started. It takes effect only with Use.
class PreparedScene {
 public:
  virtual ~PreparedScene() = default;
  PreparedScene() = default;
  PreparedScene(const PreparedScene&) = delete;
  PreparedScene& operator=(const PreparedScene&) = delete;
  [[nodiscard]] virtual SlaveDescription Describe() const = 0;
  // Saves the scene as the present one; its slave will replace the other one. Throws
  // std::runtime_error without any change if it cannot be saved.
  virtual void Use() = 0;
};

// Images of a printed chessboard; the last one shows it in the plane of tool and object.
struct BoardImages {
  std::vector<std::string> images;  // PNG or JPEG; empty: the one with which a scene would start
  int columns = 0, rows = 0;        // inner corners
  double square = 0;                // [m]
};
struct FoundBoard {
  std::vector<Eigen::Vector2d> corners;  // in the last image, row after row [px]
  double pixel = 0;                      // in the plane of the board [m/px]
  double rms_px = 0;                     // of the corners about an even grid
  std::string lens;                      // text of the lens file; empty: undetermined
  cv::Mat straight;                      // with a lens: the last image, undistorted
  std::string remark;                    // why there is no lens
};

// Calls do not overlap. Those with `progress` or `stop` throw Interrupted when it requests a stop.
class SceneSetup {
 public:
  virtual ~SceneSetup() = default;
  // Checks without changes. Throws std::invalid_argument for an invalid file name.
  virtual ProposalReport Check(const SceneProposal& proposal, Progress* progress) = 0;
  // Checks the scene, saves it in addition to the present one, and starts its slave. Throws
  // std::invalid_argument with the mistakes, and std::runtime_error if it cannot be saved.
  virtual std::unique_ptr<PreparedScene> Prepare(const SceneProposal& proposal,
                                                 Progress* progress) = 0;
  // Calls FindOutlineNear: the object's outline in `image` near the polygon `near` [px].
  virtual FoundOutline FindOutline(const cv::Mat& image, CurveView near) = 0;
  // Throws std::runtime_error: the board is not in the last image; std::invalid_argument: the
  // images.
  virtual FoundBoard FindBoard(const BoardImages& board, Progress* progress) = 0;
  // The image with which a scene would start. Throws std::runtime_error: there is none.
  [[nodiscard]] virtual cv::Mat StartImage(const std::stop_token& stop) = 0;
};

}  // namespace palpate
