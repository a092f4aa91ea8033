// Set-up of a scene while the slave runs.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slave/live/slave.h"
#include "slave/program/progress.h"

namespace palpate {

// Text of a scene, and contents of the files that it names.
struct SceneProposal {
  std::string scene;
  std::map<std::string, std::string> files;  // by name, without a folder
};

// Why a scene cannot be used. Empty or 0: unknown.
struct SceneMistake {
  std::string key, value, message, expected;
  int line = 0;  // from 1
};

struct ProposalReport {
  std::vector<SceneMistake> mistakes;  // empty: the scene can be used, and the rest is set
  std::string text;                    // what `check` prints
  SlaveDescription description;
  struct Contact {
    double depth = 0, force = 0;  // [m], [N]
    double largest_depth = 0;     // largest valid one [m]; 0: unknown
    double update = 0;            // 99th percentile of the model's update [s]
  };
  std::optional<Contact> contact;  // a typical one
};

// Images of a printed chessboard; the last one shows it in the plane of tool and object.
struct BoardImages {
  std::vector<cv::Mat> images;
  int columns = 0, rows = 0;  // inner corners
  double square = 0;          // [m]
};
struct FoundBoard {
  std::vector<Eigen::Vector2d> corners;  // in the last image, row after row [px]
  double pixel = 0;                      // in the plane of the board [m/px]
  double rms_px = 0;                     // of the corners about an even grid
  std::string lens;                      // text of the lens file; empty: undetermined
  cv::Mat straight;                      // with a lens: the last image, undistorted
  std::string remark;                    // why there is no lens
};

// Calls do not overlap.
class SceneSetup {
 public:
  virtual ~SceneSetup() = default;
  // Changes nothing. Throws std::invalid_argument: a name of a file.
  virtual ProposalReport Check(const SceneProposal& proposal, Progress* progress) = 0;
  // Checks and saves the scene and builds its slave; the result takes that into use, at once.
  // Throws std::invalid_argument: the mistakes; nothing has changed then.
  virtual std::function<void()> Prepare(const SceneProposal& proposal, Progress* progress) = 0;
  // Throws std::runtime_error: the board is not in the last image, or calibration is not installed.
  virtual FoundBoard FindBoard(const BoardImages& board) = 0;
  // The image with which a scene would start. Throws std::runtime_error: there is none.
  [[nodiscard]] virtual cv::Mat StartImage() = 0;
};

}  // namespace palpate
