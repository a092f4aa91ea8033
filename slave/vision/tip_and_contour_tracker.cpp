#include "slave/vision/tip_and_contour_tracker.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/edge_path.h"
#include "slave/vision/grey.h"
#include "slave/vision/observation.h"
#include "slave/vision/rest_contour.h"
#include "slave/vision/tip_tracker.h"

namespace palpate {
namespace {

// Limits of an outline that is known from the image alone: share with an edge, roundness (1: a
// circle), and mean strength of the edge (at most 1) unless it is very round.
constexpr double kMinClosed = 0.8, kMinRound = 0.55, kVeryRound = 0.95, kClearEdge = 0.55;

const Camera& CameraOf(const Scene& scene) {
  if (!scene.sense.Find<Camera>())
    throw std::runtime_error("sense.camera is missing: tracking needs a camera");
  if (!(scene.sense.Find<Camera>()->pixel > 0)) {
    throw std::runtime_error(
        "sense.camera.pixel = " + std::to_string(scene.sense.Find<Camera>()->pixel) +
        " m: expected > 0");
  }
  return *scene.sense.Find<Camera>();
}

// Returns the tool's direction in the image according to the scene; zero: it must be found in the
// image.
Eigen::Vector2d GivenDirection(const Scene& scene, const CameraView& view) {
  if (!scene.tool) return {0, 0};
  const Eigen::Vector3d d_S(scene.tool->direction.x(), scene.tool->direction.y(), 0);
  return (view.ToImage(view.pixel() * d_S) - view.ToImage({0, 0, 0})).stableNormalized();
}

// Returns whether the outline must be found in the image without a stated position.
bool IsOnlySeen(const Scene& scene) {
  const bool found = scene.sense.Find<ContourTracking>()->start.empty();
  return found && std::holds_alternative<ImageContourGeometry>(scene.object.geometry);
}

// Rejects outlines that are neither round nor have a clear edge all round, such as a scratch, a
// bar, a part of a bubble or a pipette's halo. The detected outline is drawn.
void RequireConvincing(const cv::Mat& first, CurveView outline) {
  cv::Mat grey8, drawn;
  first.convertTo(drawn, CV_8U, first.depth() == CV_16U ? 1.0 / 257 : 1.0);
  if (drawn.channels() == 3) cv::cvtColor(drawn, grey8, cv::COLOR_BGR2GRAY);
  if (drawn.channels() == 1) grey8 = drawn;
  const EdgePath edge = MeasureEdge(grey8, outline);
  const double length = CurveLength(outline);
  const double roundness = 4 * std::numbers::pi * std::abs(CurveArea(outline)) / (length * length);
  const bool clear = edge.strength > kClearEdge || roundness > kVeryRound;
  if (edge.closedness > kMinClosed && roundness > kMinRound && clear) return;
  if (drawn.channels() == 1) cv::cvtColor(drawn, drawn, cv::COLOR_GRAY2BGR);
  std::vector<cv::Point> points;
  for (const Eigen::Vector2d& p : outline) points.emplace_back(cvRound(p.x()), cvRound(p.y()));
  cv::polylines(drawn, points, true, cv::Scalar(0, 0, 255), 2, cv::LINE_AA);
  const auto file = std::filesystem::temp_directory_path() / "palpate-contour.png";
  const bool written = TryReplace(file, EncodePng(drawn), Links::kReplace);
  throw std::runtime_error(fmt::format(
      "no contour found: the best closed region has an edge on {:.0f} % of its outline and a "
      "roundness of {:.2f}: expected {:.0f} % and {:g}{}; give sense.contour.start",
      100 * edge.closedness, roundness, 100 * kMinClosed, kMinRound,
      written ? " (drawn in " + file.string() + ")" : ""));
}

TipTemplate MakeTemplate(const Scene& scene, const cv::Mat& first, const GreyFormat& format,
                         const CameraView& view, std::optional<Eigen::Vector2d> tip_hint_I,
                         const Eigen::Vector2d& d_I) {
  const TipTracking& options = *scene.sense.Find<TipTracking>();
  const ToolEndSize tool = scene.tool ? EndSizeOf(*scene.tool, view.pixel()) : ToolEndSize{};
  if (!options.template_file.empty()) return LoadTipTemplate(options, d_I, tool);
  if (!tip_hint_I || !scene.tool) {
    throw std::runtime_error(
        "sense.tip.template is missing, and the tool or its position is unknown as well");
  }
  if (d_I.isZero(0)) {
    throw std::runtime_error(
        "tool.direction is missing: expected [x, y], because no contour locates the object");
  }
  return CutTipTemplate(first, format, *tip_hint_I, d_I, tool, options.roi);
}

}  // namespace

struct TipAndContourTracker::Parts {
  Parts(const Scene& scene, const cv::Mat& first, std::optional<Eigen::Vector2d> tip_hint_I)
      : format(first) {
    const Camera& camera = CameraOf(scene);
    const CameraView view(camera, first.cols, first.rows);
    direction = GivenDirection(scene, view);
    GreyPatch whole;
    format.Read(first, cv::Rect(cv::Point(), first.size()), whole);
    noise = NoiseOf(whole) / format.levels_per_255();
    const double tool_width = scene.tool ? scene.tool->width / view.pixel() : 0;
    // Without a stated direction the tool points to the contour, so the contour is found first.
    const bool tip_first = !direction.isZero(0);
    if (tip_first) MakeTip(scene, first, view, tip_hint_I);
    if (scene.sense.Find<ContourTracking>()) {
      // Counter-clockwise in S is counter-clockwise in the image, unless the camera looks from
      // below.
      const bool clockwise_I = camera.X_SC.linear()(2, 2) < 0;
      contour = FindRestContour(*scene.sense.Find<ContourTracking>(), first, format, tool_width,
                                clockwise_I);
      if (IsOnlySeen(scene)) RequireConvincing(first, contour.outline);
    }
    if (!tip_first) MakeTip(scene, first, view, tip_hint_I);
  }

  void MakeTip(const Scene& scene, const cv::Mat& first, const CameraView& view,
               std::optional<Eigen::Vector2d> tip_hint_I) {
    if (!scene.sense.Find<TipTracking>()) return;
    const double tool_width = scene.tool ? scene.tool->width / view.pixel() : 0;
    if (tip_hint_I) FindDirection(first, *tip_hint_I, tool_width);
    tip.emplace(MakeTemplate(scene, first, format, view, tip_hint_I, direction), format,
                scene.sense.Find<TipTracking>()->roi, tip_hint_I);
    if (!direction.isZero(0)) return;
    const TipObservation seen = tip->Track(first);
    if (seen.found) FindDirection(first, seen.p_I, tool_width);
  }

  // Finds the tool's direction if the scene has none: towards the object, along the tool's sides.
  void FindDirection(const cv::Mat& first, const Eigen::Vector2d& p_I_tip, double tool_width) {
    const Curve& rest = contour.edge;
    if (!direction.isZero(0) || rest.empty() || !(tool_width > 0)) return;
    Eigen::Vector2d middle(0, 0);
    for (const Eigen::Vector2d& p : rest) middle += p / static_cast<double>(rest.size());
    direction = FindToolDirection(first, format, p_I_tip, middle - p_I_tip, tool_width);
  }

  GreyFormat format;
  double noise = 0;                 // of the first image [1/255 of full scale]
  Eigen::Vector2d direction{0, 0};  // of the tool in the image; zero: unknown
  std::optional<TipTracker> tip;
  RestContour contour;
  TipObservation observation;
};

TipAndContourTracker::TipAndContourTracker(const Scene& scene, const cv::Mat& first,
                                           std::optional<Eigen::Vector2d> tip_hint_I)
    : parts_(std::make_unique<Parts>(scene, first, tip_hint_I)) {}
TipAndContourTracker::~TipAndContourTracker() = default;

const TipObservation& TipAndContourTracker::Process(const cv::Mat& image) noexcept {
  TipObservation& seen = parts_->observation;
  seen = {};
  if (!parts_->format.Fits(image)) return seen;
  try {
    if (parts_->tip) seen = parts_->tip->Track(image);
  } catch (const std::exception&) {  // no memory
    seen = {};
    parts_->tip->Forget();
  }
  return seen;
}

const RestContour& TipAndContourTracker::rest_contour() const {
  return parts_->contour;
}

double TipAndContourTracker::noise() const {
  return parts_->noise;
}

Eigen::Vector2d TipAndContourTracker::tool_direction_I() const {
  return parts_->direction;
}

cv::Rect TipAndContourTracker::search_window() const {
  return parts_->tip ? parts_->tip->search_window() : cv::Rect();
}

void TipAndContourTracker::Reset() noexcept {
  if (parts_->tip) parts_->tip->Forget();
}

}  // namespace palpate
