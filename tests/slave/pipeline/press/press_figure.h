// The recorded press as a picture: force over the frames, and the field of one frame.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace palpate {

struct PressFigure {
  struct Force {
    int frame = 0;
    double measured = 0, estimated = 0, sigma = 0;  // [N]
  };
  struct Way {
    Eigen::Vector2d place;               // in the picture [px]
    double measured = 0, explained = 0;  // along the normal, outward [m]
  };
  std::string title, remark;
  int last_training_frame = 0;
  std::vector<double> wrench;  // of every row [N]
  std::vector<Force> forces;
  int field_frame = 0;
  std::vector<Way> field;
  Eigen::Vector2d contact{0, 0};  // in the picture [px]
};

// The whole SVG document.
std::string Drawn(const PressFigure& figure);

}  // namespace palpate
