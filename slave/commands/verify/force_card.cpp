#include "slave/commands/verify/force_card.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "shared/text/text.h"
#include "slave/commands/verify/card_words.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kLoadedShare = 0.05;  // of the largest known force
constexpr double kDegree = std::numbers::pi / 180;

KnownAndReported Middle(const std::vector<const MatchedState*>& states, const auto& known,
                        const auto& reported) {
  KnownAndReported middle;
  const double share = 1 / static_cast<double>(states.size());
  for (const MatchedState* one : states) {
    middle.known += share * known(*one);
    middle.reported += share * reported(*one);
    middle.sigma += share * std::hypot(one->state.sigma, one->known.sigma_or_usual());
  }
  return middle;
}

Vector3d KnownOrZero(const Vector3d& vector) {
  return vector.unaryExpr([](double x) { return std::isfinite(x) ? x : 0; });
}

std::map<int, std::vector<const MatchedState*>> ByLoad(
    const std::vector<const MatchedState*>& states) {
  std::map<int, std::vector<const MatchedState*>> loads;
  for (const MatchedState* one : states) loads[one->load].push_back(one);
  return loads;
}

// Makes the card of one tool: each member adds its lines.
class CardMaker {
 public:
  CardMaker(const std::vector<MatchedState>& matched, const SetUp& set_up, ForceCard* card)
      : set_up_(set_up), card_(*card) {
    ChooseAxes(matched);
    Sort(matched);
  }

  void AddZero();
  void AddForce();
  void AddSigma();
  void AddPosition(const std::vector<MatchedState>& matched);

 private:
  void ChooseAxes(const std::vector<MatchedState>& matched);
  void Sort(const std::vector<MatchedState>& matched);
  void AddMagnitude(const MapFit& fit);
  void AddDirections(const MapFit& fit);
  [[nodiscard]] Vector3d OnAxes(const Vector3d& vector) const;
  CardLine& Add(std::string key, std::string title) {
    return card_.lines.emplace_back(
        CardLine{std::move(key), std::move(title), Finding::kUntested, {}, {}, {}});
  }

  const SetUp& set_up_;
  ForceCard& card_;
  double largest_ = 0;                       // known force [N]
  std::vector<const MatchedState*> loaded_;  // with a force, under load
  std::vector<const MatchedState*> unloaded_;
  Vector3d offset_{0, 0, 0};  // of the unloaded force, where that is wrong [N]
};

Vector3d CardMaker::OnAxes(const Vector3d& vector) const {
  Vector3d on = Vector3d::Zero();
  for (const int axis : card_.axes) on(axis) = vector(axis);
  return on;
}

// Those that every known force has.
void CardMaker::ChooseAxes(const std::vector<MatchedState>& matched) {
  for (const int axis : {0, 1, 2}) {
    if (axis == 2 && set_up_.is_planar) continue;
    bool is_known = false, is_missing = false;
    for (const MatchedState& one : matched) {
      if (!one.known.force.array().isFinite().any()) continue;  // a press of known depth
      (std::isfinite(one.known.force(axis)) ? is_known : is_missing) = true;
    }
    if (is_known && !is_missing) card_.axes.push_back(axis);
  }
}

void CardMaker::Sort(const std::vector<MatchedState>& matched) {
  const auto is_compared = [&](const MatchedState& one) {
    return !card_.axes.empty() && OnAxes(one.known.force).allFinite() &&
           one.known.force.array().isFinite().any() && OnAxes(one.state.force).allFinite();
  };
  for (const MatchedState& one : matched) {
    if (is_compared(one)) largest_ = std::fmax(largest_, OnAxes(one.known.force).norm());
  }
  int valid = 0;
  for (const MatchedState& one : matched) {
    if (!is_compared(one)) continue;
    const bool is_loaded = OnAxes(one.known.force).norm() >= kLoadedShare * largest_;
    (is_loaded && largest_ > 0 ? loaded_ : unloaded_).push_back(&one);
    if (is_loaded && one.state.is_valid) ++valid;
  }
  card_.flagged = static_cast<int>(loaded_.size()) - valid;
  // Flagged states count only where they are the rule.
  if (valid > card_.flagged) {
    std::erase_if(loaded_, [](const MatchedState* one) { return !one->state.is_valid; });
  }
  card_.states = static_cast<int>(loaded_.size());
}

void CardMaker::AddZero() {
  CardLine& line = Add("zero", "Force without a load");
  constexpr std::size_t kParts = 10;
  const std::size_t parts = std::min(kParts, unloaded_.size());
  if (parts < 3 || !(largest_ > 0)) {
    line.remark = "no load of zero was held";
    return;
  }
  std::vector<Vector3d> means(parts, Vector3d::Zero());
  std::vector<double> counts(parts, 0);
  for (std::size_t i = 0; i < unloaded_.size(); ++i) {
    const std::size_t part = i * parts / unloaded_.size();
    means[part] += OnAxes(unloaded_[i]->state.force) - OnAxes(unloaded_[i]->known.force);
    ++counts[part];
  }
  Vector3d mean = Vector3d::Zero(), spread = Vector3d::Zero();
  const double n = static_cast<double>(parts);
  for (std::size_t i = 0; i < parts; ++i) mean += means[i] / counts[i] / n;
  for (std::size_t i = 0; i < parts; ++i) spread += (means[i] / counts[i] - mean).cwiseAbs2();
  const double reach = StudentReach(n - 1) * std::sqrt(spread.sum() / (n * (n - 1)));
  line.interval = {mean.norm(), std::fmax(0, mean.norm() - reach), mean.norm() + reach};
  line.value = Words(*line.interval, " N", 1, 4);
  line.remark = Formatted("right is at most %.3g N, %g %% of the largest load",
                          kZeroTolerance * largest_, 100 * kZeroTolerance);
  line.finding = Judged(*line.interval, 0, kZeroTolerance * largest_);
  if (line.finding == Finding::kWrong) offset_ = mean;
}

void CardMaker::AddForce() {
  for (const auto& [load, states] : ByLoad(loaded_)) {
    card_.loads.push_back(Middle(
        states, [&](const MatchedState& one) { return OnAxes(one.known.force); },
        [&](const MatchedState& one) -> Vector3d { return OnAxes(one.state.force) - offset_; }));
  }
  card_.force = FitMap(card_.loads, card_.axes);
  AddMagnitude(card_.force);
  AddDirections(card_.force);
}

void CardMaker::AddMagnitude(const MapFit& fit) {
  CardLine& line = Add("magnitude", "Force magnitude");
  if (fit.directions == 0) {
    line.remark = "no state has a force under a known force";
    if (!card_.loads.empty()) {
      line.finding = Finding::kWrong;
      line.remark = "the reported force is zero under every load";
    }
    return;
  }
  if (!fit.is_decided) {
    line.finding = Finding::kOpen;
    line.remark = Formatted("%d loads in %d directions: hold at least %d loads", fit.loads,
                            fit.directions, fit.directions + 2);
    return;
  }
  const double low = 1 - kForceTolerance, high = 1 + kForceTolerance;
  line.interval = fit.gain;
  line.value = Words(fit.gain);
  line.finding = Judged(fit.gain, low, high);
  line.remark = Formatted("reported / known, right is %g to %g", low, high);
  for (std::size_t j = 0; j < 3; ++j) {
    if (!fit.axis_gain[j]) continue;
    const Finding of_axis = Judged(*fit.axis_gain[j], low, high);
    line.remark += std::string("; ") + kAxisNames[j] + ": " + Words(*fit.axis_gain[j]);
    // The worse one of the axes counts: wrong, then open.
    if (of_axis == Finding::kWrong || line.finding == Finding::kRight) line.finding = of_axis;
  }
}

void CardMaker::AddDirections(const MapFit& fit) {
  const Finding unknown = fit.directions == 0 ? Finding::kUntested : Finding::kOpen;
  CardLine sign{"sign", "Sign", unknown, {}, {}, {}};
  CardLine frame{"frame", "Frame", unknown, {}, {}, {}};
  if (fit.is_decided) {
    sign.interval = fit.along;
    sign.value = Words(fit.along, "", 1, 2);
    sign.remark = "cosine of reported and known force, 1 is right, -1 is reversed";
    frame.interval = fit.turn;
    frame.value = Words(fit.turn, " deg", 1 / kDegree, 1);
    frame.remark = Formatted("turn, right is at most %.0f deg", kTurnTolerance / kDegree);
    std::vector<int> tested;
    for (int axis = 0; axis < 3; ++axis) {
      if (fit.axis_gain[static_cast<std::size_t>(axis)]) tested.push_back(axis);
    }
    frame.remark += tested.empty() ? "; loads in one oblique direction"
                                   : "; tested by loads along " + AxisNames(tested);
    if (fit.relation_is_clear) {
      sign.finding = fit.relation.is_flipped() ? Finding::kWrong : Finding::kRight;
      frame.finding =
          fit.relation.is_permuted() ? Finding::kWrong : Judged(fit.turn, 0, kTurnTolerance);
      if (fit.relation.is_permuted() || fit.relation.is_flipped()) {
        const std::string words = RelationWords(fit.relation, card_.axes);
        (fit.relation.is_permuted() ? frame : sign).remark += "; " + words;
      }
    }
  }
  card_.lines.push_back(std::move(sign));
  card_.lines.push_back(std::move(frame));
}

void CardMaker::AddSigma() {
  CardLine& line = Add("sigma", "Sigma");
  double one = 0, two = 0, squares = 0;
  for (const MatchedState* matched : loaded_) {
    const Vector3d known = OnAxes(matched->known.force), told = OnAxes(matched->state.force);
    const double error =
        set_up_.sigma_of_vector ? (told - known).norm() : std::abs(told.norm() - known.norm());
    const double sigma = std::hypot(matched->state.sigma, matched->known.sigma_or_usual());
    one += error <= sigma ? 1 : 0;
    two += error <= 2 * sigma ? 1 : 0;
    squares += error * error / std::fmax(sigma * sigma, 1e-12 * largest_ * largest_);
  }
  const auto loads = static_cast<int>(ByLoad(loaded_).size());
  if (loads == 0) {
    line.remark = "no state has a force under a known force";
    return;
  }
  const double count = static_cast<double>(loaded_.size());
  const Interval within_one = ShareInterval(one / count, loads);
  const Interval within_two = ShareInterval(two / count, loads);
  line.interval = within_two;
  line.value = "within 1 sigma " + Words(within_one, " %", 100, 0) + ", within 2 sigma " +
               Words(within_two, " %", 100, 0);
  constexpr double kWithinOne = 0.683, kWithinTwo = 0.954;
  const double rms = std::sqrt(squares / count);
  // An error that all loads share, as that of a modulus, may be two sigma of one load in twenty
  // set-ups. Errors that are not larger than this are no proof.
  constexpr double kTooLarge = 1.6;
  line.finding =
      within_two.high < kWithinTwo && rms > kTooLarge ? Finding::kWrong : Finding::kRight;
  line.remark = Formatted("expected 68 %% and 95 %%; errors are %.2g sigma rms", rms);
  if (line.finding == Finding::kRight && within_one.high < kWithinOne) {
    line.remark += "; fewer than expected are within 1 sigma, as with one error of all loads";
  }
  constexpr double kCautious = 0.3;
  if (rms < kCautious) line.remark += "; sigma is larger than these errors need";
}

void CardMaker::AddPosition(const std::vector<MatchedState>& matched) {
  CardLine& line = Add("position", "Position scale");
  // Where positions are known they count, else depths, as a position on one axis.
  const auto known_tip = [](const MatchedState& one) { return one.known.p_S_tip; };
  std::vector<int> axes;
  for (const int axis : {0, 1, 2}) {
    if (axis == 2 && set_up_.is_planar) continue;
    if (std::ranges::any_of(matched, [&](const MatchedState& one) {
          return std::isfinite(one.known.p_S_tip(axis)) && std::isfinite(one.state.p_S_tip(axis));
        })) {
      axes.push_back(axis);
    }
  }
  const bool by_depth = axes.empty();
  if (by_depth) axes = {0};
  const auto known = [&](const MatchedState& one) -> Vector3d {
    return by_depth ? Vector3d(one.known.depth, 0, 0) : known_tip(one);
  };
  const auto reported = [&](const MatchedState& one) -> Vector3d {
    return by_depth ? Vector3d(one.state.depth, 0, 0) : one.state.p_S_tip;
  };
  std::vector<const MatchedState*> states;
  for (const MatchedState& one : matched) {
    if (std::ranges::all_of(axes, [&](int axis) {
          return std::isfinite(known(one)(axis)) && std::isfinite(reported(one)(axis));
        })) {
      states.push_back(&one);
    }
  }
  std::vector<KnownAndReported> middles;
  Vector3d mean_known = Vector3d::Zero(), mean_reported = Vector3d::Zero();
  for (const auto& [load, of_load] : ByLoad(states)) {
    auto& middle = middles.emplace_back(Middle(
        of_load, [&](const MatchedState& one) { return KnownOrZero(known(one)); },
        [&](const MatchedState& one) { return KnownOrZero(reported(one)); }));
    middle.sigma = 0;
    mean_known += middle.known;
    mean_reported += middle.reported;
  }
  for (KnownAndReported& middle : middles) {
    middle.known -= mean_known / static_cast<double>(middles.size());
    middle.reported -= mean_reported / static_cast<double>(middles.size());
  }
  const MapFit fit = FitMap(middles, axes);
  if (fit.directions == 0) {
    line.remark = "no position or depth is known";
    return;
  }
  card_.position = fit;
  line.finding = Finding::kOpen;
  if (!fit.is_decided) {
    line.remark = Formatted("%d known positions: hold at least %d", fit.loads, fit.directions + 2);
    return;
  }
  const double low = 1 - kPositionTolerance, high = 1 + kPositionTolerance;
  line.interval = fit.gain;
  line.value = Words(fit.gain, "", 1, 4);
  line.remark = Formatted("%s reported / known, right is %g to %g",
                          by_depth ? "change of depth" : "travel of the tip", low, high);
  line.finding = Judged(fit.gain, low, high);
  if (fit.relation_is_clear && (fit.relation.is_permuted() || fit.relation.is_flipped())) {
    line.finding = Finding::kWrong;
    line.remark += "; axes of positions: " + RelationWords(fit.relation, card_.axes);
  } else if (!by_depth && fit.turn.low > kTurnTolerance) {
    line.finding = Finding::kWrong;
    line.remark += "; travel is turned by " + Words(fit.turn, " deg", 1 / kDegree, 1);
  }
}

}  // namespace

std::string_view ToString(Finding finding) {
  constexpr std::array<std::string_view, 4> kWords{"right", "wrong", "not decided", "not tested"};
  return kWords[static_cast<std::size_t>(finding)];
}

const CardLine& ForceCard::line(std::string_view key) const {
  return *std::ranges::find(lines, key, &CardLine::key);
}

bool ForceCard::passes() const {
  return line("magnitude").finding == Finding::kRight &&
         std::ranges::none_of(lines, [](const CardLine& one) {
           return one.finding == Finding::kWrong || one.finding == Finding::kOpen;
         });
}

ForceCard MakeCard(const std::string& finger, const std::vector<MatchedState>& matched,
                   const SetUp& set_up) {
  ForceCard card;
  card.finger = finger;
  CardMaker maker(matched, set_up, &card);
  maker.AddZero();
  maker.AddForce();
  maker.AddSigma();
  maker.AddPosition(matched);
  card.causes = CausesOf(card, set_up);
  return card;
}

}  // namespace palpate
