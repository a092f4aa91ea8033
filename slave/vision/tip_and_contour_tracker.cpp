#include "slave/vision/tip_and_contour_tracker.h"

#include <optional>
#include <stdexcept>
#include <string>

#include <opencv2/core.hpp>

#include "slave/vision/contour_tracker.h"
#include "slave/vision/grey.h"
#include "slave/vision/observation.h"
#include "slave/vision/tip_tracker.h"

namespace palpate {
namespace {

const Camera& CameraOf(const Scene& scene) {
  if (!scene.sense.Find<Camera>())
    throw std::runtime_error("sense.camera is missing: the eyes need one");
  if (!(scene.sense.Find<Camera>()->pixel > 0)) {
    throw std::runtime_error(
        "sense.camera.pixel = " + std::to_string(scene.sense.Find<Camera>()->pixel) +
        " m: accepted is > 0");
  }
  return *scene.sense.Find<Camera>();
}

TipTemplate MakeTemplate(const Scene& scene, const cv::Mat& first, const GreyFormat& format,
                         const CameraView& view, std::optional<Eigen::Vector2d> tip_hint_I) {
  const TipTracking& options = *scene.sense.Find<TipTracking>();
  if (!options.template_file.empty()) return LoadTipTemplate(options);
  if (!tip_hint_I || !scene.tool) {
    throw std::runtime_error(
        "sense.tip.template is missing, and where the tool is, or the tool, is not known either");
  }
  const Eigen::Vector3d p_S = view.ToSlave(*tip_hint_I);
  const Eigen::Vector3d d_S(scene.tool->direction.x(), scene.tool->direction.y(), 0);
  const Eigen::Vector2d d_I =
      (view.ToImage(p_S + view.pixel() * d_S) - view.ToImage(p_S)).normalized();
  return CutTipTemplate(first, format, *tip_hint_I, d_I, scene.tool->width / view.pixel(),
                        options.roi);
}

}  // namespace

struct TipAndContourTracker::Parts {
  Parts(const Scene& scene, const cv::Mat& first, std::optional<Eigen::Vector2d> tip_hint_I)
      : format(first) {
    const Camera& camera = CameraOf(scene);
    const CameraView view(camera, first.cols, first.rows);
    if (scene.sense.Find<TipTracking>()) {
      const TipTracker::Options options{scene.sense.Find<TipTracking>()->roi,
                                        scene.sense.Find<TipTracking>()->min_score};
      tip.emplace(MakeTemplate(scene, first, format, view, tip_hint_I), format, options,
                  tip_hint_I);
    }
    if (scene.sense.Find<ContourTracking>()) {
      // Counter-clockwise in S is counter-clockwise to the eye, unless the camera looks from below.
      const bool clockwise_I = camera.X_SC.linear()(2, 2) < 0;
      const double tool_width = scene.tool ? scene.tool->width / view.pixel() : 0;
      contour.emplace(*scene.sense.Find<ContourTracking>(), first, format, tool_width, clockwise_I);
    }
  }

  GreyFormat format;
  std::optional<TipTracker> tip;
  std::optional<ContourTracker> contour;
  Observation observation;
};

TipAndContourTracker::TipAndContourTracker(const Scene& scene, const cv::Mat& first,
                                           std::optional<Eigen::Vector2d> tip_hint_I)
    : parts_(std::make_unique<Parts>(scene, first, tip_hint_I)) {}
TipAndContourTracker::~TipAndContourTracker() = default;

const Observation& TipAndContourTracker::Look(const cv::Mat& image, std::uint64_t sequence,
                                              Time sensed_at) noexcept {
  Observation& seen = parts_->observation;
  seen = {};
  seen.sequence = sequence;
  seen.sensed_at = sensed_at;
  if (!parts_->format.Fits(image)) return seen;
  try {
    if (parts_->tip) seen.tip = parts_->tip->Track(image);
  } catch (const std::bad_alloc&) {  // the search over the whole picture found no memory
    seen.tip = {};
    parts_->tip->Forget();
  }
  if (parts_->contour) seen.contour_I = parts_->contour->Track(image);
  return seen;
}

const std::vector<Eigen::Vector2d>& TipAndContourTracker::rest_contour_I() const {
  static const std::vector<Eigen::Vector2d> kNone;
  return parts_->contour ? parts_->contour->rest() : kNone;
}

cv::Rect TipAndContourTracker::search_window() const {
  return parts_->tip ? parts_->tip->search_window() : cv::Rect();
}

void TipAndContourTracker::Reset() noexcept {
  if (parts_->tip) parts_->tip->Forget();
  if (parts_->contour) parts_->contour->Restart();
}

}  // namespace palpate
