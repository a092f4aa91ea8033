#include "slave/commands/verify/position_lines.h"

#include <algorithm>
#include <cmath>

#include "shared/text/text.h"
#include "slave/commands/verify/card_statistics.h"
#include "slave/commands/verify/card_words.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Known and reported positions on the axes that both have; without any, depths on the first axis.
class Positions {
 public:
  Positions(const std::vector<MatchedState>& matched, bool is_planar) {
    for (int axis = 0; axis < (is_planar ? 2 : 3); ++axis) {
      const bool is_known = std::ranges::any_of(matched, [&](const MatchedState& one) {
        return std::isfinite(one.known.p_S_tip(axis)) && std::isfinite(one.state.p_S_tip(axis));
      });
      if (is_known) axes_.push_back(axis);
    }
    by_depth_ = axes_.empty();
    if (by_depth_) axes_ = {0};
    for (const MatchedState& one : matched) {
      if (IsComplete(one)) states_.push_back(&one);
    }
    FindMeans();
  }

  [[nodiscard]] bool by_depth() const { return by_depth_; }
  [[nodiscard]] const std::vector<int>& axes() const { return axes_; }
  // The means of each load, relative to the mean of all.
  [[nodiscard]] const std::vector<KnownAndReported>& means() const { return means_; }
  // Mean of the reported position minus the known one, frame S [m].
  [[nodiscard]] const Vector3d& offset() const { return offset_; }

 private:
  [[nodiscard]] Vector3d Known(const MatchedState& one) const {
    return by_depth_ ? Vector3d(one.known.depth, 0, 0) : one.known.p_S_tip;
  }
  [[nodiscard]] Vector3d Reported(const MatchedState& one) const {
    return by_depth_ ? Vector3d(one.state.depth, 0, 0) : one.state.p_S_tip;
  }
  [[nodiscard]] bool IsComplete(const MatchedState& one) const {
    return std::ranges::all_of(axes_, [&](int axis) {
      return std::isfinite(Known(one)(axis)) && std::isfinite(Reported(one)(axis));
    });
  }
  void FindMeans() {
    const auto or_zero = [](const Vector3d& vector) -> Vector3d {
      return vector.unaryExpr([](double x) { return std::isfinite(x) ? x : 0; });
    };
    Vector3d known = Vector3d::Zero(), reported = Vector3d::Zero();
    for (const auto& [load, states] : ByLoad(states_)) {
      auto& mean = means_.emplace_back(MeanOf(
          states, [&](const MatchedState& one) { return or_zero(Known(one)); },
          [&](const MatchedState& one) { return or_zero(Reported(one)); }));
      mean.sigma = 0;
      known += mean.known;
      reported += mean.reported;
    }
    const auto count = static_cast<double>(means_.size());
    for (KnownAndReported& mean : means_) {
      mean.known -= known / count;
      mean.reported -= reported / count;
    }
    offset_ = (reported - known) / count;
  }

  std::vector<int> axes_;
  bool by_depth_ = false;
  std::vector<const MatchedState*> states_;
  std::vector<KnownAndReported> means_;
  Vector3d offset_ = Vector3d::Zero();
};

CardLine PlaceLine(const Vector3d& offset, double object_size) {
  CardLine line{"place", "Tip position", Finding::kUntested, {}, {}, {}};
  const double size = offset.norm(), right = kPlaceTolerance * object_size;
  line.value = Formatted("%.3g mm beside the known one: (%.3g, %.3g, %.3g) mm", 1e3 * size,
                         1e3 * offset.x(), 1e3 * offset.y(), 1e3 * offset.z());
  line.remark = Formatted("right is at most %.3g mm", 1e3 * right);
  line.finding = size > right ? Finding::kWrong : Finding::kRight;
  return line;
}

CardLine ScaleLine(const MapFit& fit, bool by_depth, const std::vector<int>& force_axes) {
  CardLine line{"position", "Position scale", Finding::kOpen, {}, {}, {}};
  if (!fit.is_decided) {
    line.remark = Formatted("%d known positions: hold at least %d", fit.loads, fit.directions + 2);
    return line;
  }
  const double low = 1 - kPositionTolerance, high = 1 + kPositionTolerance;
  line.interval = fit.gain;
  line.value = Words(fit.gain, "", 1, 4);
  line.remark = Formatted("%s reported / known, right is %g to %g",
                          by_depth ? "change of depth" : "travel of the tip", low, high);
  line.finding = Judged(fit.gain, low, high);
  if (fit.relation_is_clear && (fit.relation.is_permuted() || fit.relation.is_flipped())) {
    line.finding = Finding::kWrong;
    line.remark += "; axes of positions: " + RelationWords(fit.relation, force_axes);
  } else if (!by_depth && fit.turn.low > kTurnTolerance) {
    line.finding = Finding::kWrong;
    line.remark += "; travel is turned by " + Words(fit.turn, " deg", 1 / kDegree, 1);
  }
  return line;
}

}  // namespace

void AddPosition(const std::vector<MatchedState>& matched, const SetUp& set_up, ForceCard* card) {
  const Positions positions(matched, set_up.is_planar);
  if (!positions.by_depth() && !positions.means().empty() && set_up.object_size > 0) {
    card->lines.push_back(PlaceLine(positions.offset(), set_up.object_size));
  }
  const MapFit fit = FitMap(positions.means(), positions.axes());
  if (fit.directions == 0) {
    card->lines.push_back({"position",
                           "Position scale",
                           Finding::kUntested,
                           {},
                           {},
                           "no position or depth is known"});
    return;
  }
  card->position = fit;
  card->lines.push_back(ScaleLine(fit, positions.by_depth(), card->axes));
}

}  // namespace palpate
