// The tool's tip: its template, and its position from image to image.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/grey.h"
#include "slave/vision/ncc.h"
#include "slave/vision/observation.h"
#include "slave/vision/patch_aligner.h"
#include "slave/vision/tool_end.h"

namespace palpate {

// Template of the tip, and the tip's position in it.
struct TipTemplate {
  GreyPatch pixels;
  // The tip relative to the upper left pixel's centre [px]; may be outside of the template.
  Eigen::Vector2d anchor{0, 0};
  // Per pixel: how far the fine alignment trusts it, 0 or 1.
  std::vector<float> weights;
  Eigen::Vector2d along{0, 0};  // unit vector along which the tool points [px]; zero: not known

  // Aligns its pixels but the outermost ones, which have no central difference.
  [[nodiscard]] PatchAligner Aligner() const;
  [[nodiscard]] Eigen::Vector2d Centre() const;  // from the upper left pixel's centre [px]
};

// Reads the scene's template file. Without an anchor, the tip is at the midpoint of its lower edge.
// Throws std::runtime_error naming the key and the file: unreadable, too small (below 5 px), too
// large (above 512 px), without contrast. Background beside the end of a tool that points along
// `d_I` has no weight, see CutTipTemplate; a zero vector: unknown.
TipTemplate LoadTipTemplate(const TipTracking& options, const Eigen::Vector2d& d_I,
                            const ToolEndSize& tool);

// Cuts the template from the image `first`: the tool is a bar whose end is at `p_I_tip`, pointing
// along the unit vector `d_I` (both in I).
//
// The window contains the tool and a little background on either side, but nothing beyond the tip,
// where the object will be and deform. It needs marks (or a taper) on the tool: without them a few
// pixels beyond the tip are included, because otherwise the position along the tool is not
// determined. Background beside the tool's end has no weight, because the indented object rises
// there, nor has the region beyond the circle of a round end with marks. A window is upright, so
// for an oblique tool it ends somewhat before the tip. Throws std::runtime_error: the tip or too
// much of the tool lies outside the image, no contrast.
TipTemplate CutTipTemplate(const cv::Mat& first, const GreyFormat& format,
                           const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& d_I,
                           const ToolEndSize& tool, int roi);

// The unit vector along the bar of `width` [px] that ends at `p_I_tip`, within 60 degrees of
// `towards`: the direction with the largest change across the two sides.
Eigen::Vector2d FindToolDirection(const cv::Mat& first, const GreyFormat& format,
                                  const Eigen::Vector2d& p_I_tip, const Eigen::Vector2d& towards,
                                  double width);

// The parts of a template that change along the tool, each correlated separately. A bar's
// silhouette, which dominates a whole template, is the same at all positions along the bar; its
// marks and its end are not. If most parts fit, the tip is found although something covers the
// others.
class TemplateParts {
 public:
  // Parts without contrast, or beside the tool's end, are not used. Needs the tool's direction.
  explicit TemplateParts(const TipTemplate& tip);
  // Enough parts for a decision.
  [[nodiscard]] bool usable() const;

  struct Place {
    cv::Point at;      // of the template's upper left pixel
    double score = 0;  // mean of the better half of the parts
    // The best score is on the border of the window, so a better one may be outside.
    bool on_border = false;
    double second = 0;  // the score of the second-best position that is not the same peak
  };
  // The best position in `window`.
  Place Find(const GreyPatch& window);
  // The best score within a pixel of `at`.
  double ScoreNear(const GreyPatch& window, const cv::Point& at);
  // Score that a perfect match has under white noise [levels]. Uses only the usable parts.
  [[nodiscard]] double Attenuation(double noise) const;
  // Returns for each pixel of the template except the outermost ones whether its part fits at the
  // last position: 1 or 0.
  [[nodiscard]] std::span<const float> trust() const {
    return {trust_.ptr<float>(), trust_.total()};
  }

 private:
  struct Part {
    cv::Point corner;
    Ncc ncc;
  };
  template <typename Score>
  double BetterHalf(const Score& score);
  void MarkFitting(const cv::Point& at);

  int width_, height_;
  cv::Point step_;             // of the difference along the tool [px]
  int max_difference_ = 2047;  // difference that counts, to either side [levels]
  double variance_ = 0;        // of a part's differences, mean [levels^2]
  double signal_ = 0;          // variance beyond the template's own noise [levels^2]
  std::vector<Part> parts_;
  std::vector<double> scores_;  // of the parts at one position
  GreyPatch change_, crop_;
  cv::Mat_<float> trust_;
};

// Tracks the tool's tip from image to image: normalised cross-correlation in a moving window (paper
// A, 3.2), sub-pixel alignment, loss and re-acquisition. If the whole template does not fit, or
// much of it is covered, its parts decide. Follows a tool that slowly tilts.
class TipTracker {
 public:
  // `roi`: edge of the search window [px]; it grows to 10 px around the template. `start_I`: first
  // search position [px]; nullopt: everywhere. Throws std::runtime_error: the template is larger
  // than the image; std::invalid_argument: it has no contrast.
  TipTracker(const TipTemplate& tip, const GreyFormat& format, int roi,
             std::optional<Eigen::Vector2d> start_I);

  // Processes one image (which fits the format). The tip is lost if the best score is below 0.6,
  // on the border of the window even after widening it, or matched by another position; then the
  // whole image is searched. May throw std::bad_alloc.
  TipObservation Track(const cv::Mat& image);

  // Returns the first search position in the next image [px].
  [[nodiscard]] cv::Rect search_window() const;
  // Searches the whole next image.
  void Forget() noexcept { last_.reset(); }

 private:
  struct Match {
    bool on_border = false;
    TipObservation tip;
    double fit = 0;  // score of the parts there
  };
  struct Candidate {
    cv::Point corner;
    double score = 0;
  };

  [[nodiscard]] cv::Rect WindowAround(const Eigen::Vector2d& tip, double scale) const;
  [[nodiscard]] Eigen::Vector2d Predicted() const;
  TipObservation TrackTurned(const cv::Mat& image);
  void Straighten(const cv::Mat& image);
  TipObservation TrackStraight(const cv::Mat& image);
  void FollowTurn(const cv::Mat& image, TipObservation* tip);
  Match SearchWindow(const cv::Mat& image, const cv::Rect& window);
  TipObservation SearchImage(const cv::Mat& image);
  [[nodiscard]] bool IsSureAgain(const TipObservation& tip) const;
  void FindCandidates(const cv::Mat& image);
  TipObservation Measure(double score, const cv::Rect& window, const cv::Point& peak);
  [[nodiscard]] PatchWarp PatchAt(const cv::Point& corner) const;
  void SetPosition(const PatchAligner::Match& fine, const cv::Rect& window,
                   TipObservation* tip) const;
  double Confirm(const cv::Rect& window, const cv::Point& peak, TipObservation& tip);
  TipObservation MeasureByParts(const cv::Rect& window, double usual);

  GreyFormat format_;
  int roi_;
  Eigen::Vector2d anchor_, centre_;  // of the template [px]
  Eigen::Vector2d lever_;            // TipObservation::lever
  Ncc ncc_;
  PatchAligner aligner_;
  TemplateParts parts_;
  int shrink_ = 1;  // of a search in the whole image
  std::optional<Ncc> coarse_;
  GreyPatch window_, whole_, shrunk_;
  std::vector<Candidate> candidates_;

  std::optional<Eigen::Vector2d> last_;  // tip in the last image; none: lost
  Eigen::Vector2d step_{0, 0};           // from the last but one to the last [px]
  // Rotation of a hand-held tool: the image is rotated back about the last tip before the search.
  double turn_ = 0;          // as TipObservation::turn, of the image that is straightened [rad]
  bool has_turned_ = false;  // the tool has rotated at least once
  int lost_ = 0;             // images since the tip was found
  cv::Mat straight_;
  GreyPatch near_;    // around the tip that was found
  double usual_ = 0;  // score of the parts at the tip without noise; 0: unknown
};

}  // namespace palpate
