// Follows the tool's tip from picture to picture: normalised cross-correlation in a moving window
// (paper A, 3.2), sub-pixel alignment, loss and re-acquisition.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"
#include "slave/vision/ncc.h"
#include "slave/vision/observation.h"
#include "slave/vision/template_aligner.h"
#include "slave/vision/tip_template.h"

namespace palpate {

class TipTracker {
 public:
  struct Options {
    int roi = 64;            // edge of the search window [px]; grows to 10 px around the template
    double min_score = 0.6;  // below it the tip is lost
  };

  // `start_I`: where to look first [px]; nullopt: everywhere. Throws std::runtime_error: the
  // template is larger than the picture; std::invalid_argument: it has no contrast.
  TipTracker(const TipTemplate& tip, const GreyFormat& format, const Options& options,
             std::optional<Eigen::Vector2d> start_I);

  // Looks at one picture (which fits the format). The tip is lost where the best score is below
  // `min_score`, on the border of the window even after widening it, or matched by another place;
  // then the whole picture is searched. May throw std::bad_alloc while it searches there first.
  TipObservation Track(const cv::Mat& image);

  // Where the next picture is searched first [px].
  [[nodiscard]] cv::Rect search_window() const;
  // Searches the whole picture next time.
  void Forget() noexcept { last_.reset(); }

 private:
  struct Match {
    bool found = false, on_border = false;
    TipObservation tip;
  };
  struct Candidate {
    cv::Point corner;
    double score = 0;
  };

  [[nodiscard]] cv::Rect WindowAround(const Eigen::Vector2d& tip, double scale) const;
  [[nodiscard]] Eigen::Vector2d Predicted() const;
  Match SearchWindow(const cv::Mat& image, const cv::Rect& window);
  TipObservation SearchPicture(const cv::Mat& image);
  void FindCandidates(const cv::Mat& image);
  TipObservation Measure(const ScoreMap& map, const cv::Rect& window, const cv::Point& peak);

  GreyFormat format_;
  Options options_;
  Eigen::Vector2d anchor_;
  Ncc ncc_;
  TemplateAligner aligner_;
  int shrink_ = 1;  // of the search over the whole picture
  std::optional<Ncc> coarse_;
  GreyPatch window_, whole_, shrunk_;
  std::vector<Candidate> candidates_;

  std::optional<Eigen::Vector2d> last_;  // tip in the last picture; none: lost
  Eigen::Vector2d step_{0, 0};           // from the last but one to the last [px]
};

}  // namespace palpate
