#include "master/view/finger_layer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "master/view/scale.h"

namespace palpate {
namespace {

constexpr double kHead = 18, kHalfHead = 8;  // of an arrow [px]
constexpr double kShortest = 2;              // what is shorter points nowhere [px]
constexpr double kRing = 7;                  // radius of a free finger [px]
constexpr double kGap = 10;                  // between an arrow and its words [px]

// Head, then shaft, of an arrow; the head shrinks with short ones.
struct Arrow {
  Eigen::Vector2d tail, neck, head, side;

  Arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to) : tail(from), head(to) {
    const Eigen::Vector2d along = (to - from).stableNormalized();
    const double size = std::min(1.0, (to - from).norm() / (1.5 * kHead));
    neck = to - size * kHead * along;
    side = size * kHalfHead * Eigen::Vector2d(-along.y(), along.x());
  }
  [[nodiscard]] std::array<Eigen::Vector2d, 3> Point() const {
    return {head, neck + side, neck - side};
  }
};

std::string Words(Validity validity) {
  std::string words(ToString(validity));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

bool ComesFromBehind(const FingerMark& mark, const Viewpoint& view) {
  return view.Nearness(PressOf(mark.finger.felt)) > 0;
}

// Beside `at`, away from the arrow that starts there along `outward`.
void PaintLabel(const NamedFinger& finger, const Eigen::Vector2d& at,
                const Eigen::Vector2d& outward, Svg* drawing) {
  constexpr double kLine = 17;  // [px]
  const Eigen::Vector2d away = outward.stableNormalized();
  const auto anchor = away.x() < -0.4  ? Svg::Anchor::kEnd
                      : away.x() > 0.4 ? Svg::Anchor::kStart
                                       : Svg::Anchor::kMiddle;
  const double rise = away.y() < 0 ? -kLine : 4;
  const Eigen::Vector2d first = at + kGap * away + Eigen::Vector2d(0, rise + 4);
  drawing->Text(first, finger.name, "finger-name", anchor);
  drawing->Text(first + Eigen::Vector2d(0, kLine), InWords(finger.felt), "ink", anchor);
}

void PaintFinger(const FingerMark& mark, const Viewpoint& view, double length, Layer layer,
                 Svg* drawing) {
  const Eigen::Vector2d head = view.ToPicture(mark.place);
  const Eigen::Vector2d way = view.Direction(PressOf(mark.finger.felt), length);
  const bool behind = ComesFromBehind(mark, view);
  if (layer == Layer::kBehind) {
    if (behind && way.norm() > kShortest) PaintArrow(head - way, head, drawing);
    return;
  }
  if (way.norm() <= kShortest) {
    drawing->Circle(head, kRing, mark.finger.felt.in_contact ? "touch" : "free");
    return PaintLabel(mark.finger, head + Eigen::Vector2d(kRing, 0), {1, -0.2}, drawing);
  }
  if (behind) {
    const Arrow arrow(head - way, head);
    drawing->Line(arrow.tail, arrow.neck, "through");
    drawing->Polygon(arrow.Point(), "through-head");
  } else {
    PaintArrow(head - way, head, drawing);
  }
  PaintLabel(mark.finger, head - way, -way, drawing);
}

}  // namespace

Eigen::Vector3d PressOf(const FingerState& finger) {
  const bool known = finger.in_contact && finger.force && IsForceKnown(finger.validity);
  return known ? Eigen::Vector3d(-finger.force->cast<double>()) : Eigen::Vector3d(0, 0, 0);
}

std::string InWords(const FingerState& finger) {
  if (!finger.force || !IsForceKnown(finger.validity)) {
    return "force unknown (" + Words(finger.validity) + ")";
  }
  if (!finger.in_contact) return "free";
  std::string words = Readable(finger.force->cast<double>().norm()) + " N";
  if (finger.validity != Validity::kValid) words += ", " + Words(finger.validity);
  return words;
}

void PaintFingers(const std::vector<FingerMark>& marks, const Viewpoint& view, double length,
                  Layer layer, Svg* drawing) {
  for (const FingerMark& mark : marks) PaintFinger(mark, view, length, layer, drawing);
}

void PaintArrow(const Eigen::Vector2d& tail, const Eigen::Vector2d& head, Svg* drawing) {
  const Arrow arrow(tail, head);
  const auto point = arrow.Point();
  drawing->Line(arrow.tail, arrow.neck, "halo");
  drawing->Polygon(point, "halo");
  drawing->Line(arrow.tail, arrow.neck, "shaft");
  drawing->Polygon(point, "head");
}

}  // namespace palpate
