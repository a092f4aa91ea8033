#include "slave/commands/verify/force_card.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/QR>

#include "shared/text/text.h"
#include "slave/commands/verify/card_statistics.h"
#include "slave/commands/verify/card_words.h"
#include "slave/commands/verify/position_lines.h"
#include "slave/commands/verify/record_fit.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLoadedShare = 0.05;  // of the largest known force

// Errors in units of sigma.
struct SigmaCheck {
  double count = 0, within_one = 0, within_two = 0, squares = 0;

  void Add(double error, double sigma) {
    ++count;
    within_one += error <= sigma ? 1 : 0;
    within_two += error <= 2 * sigma ? 1 : 0;
    squares += error * error / (sigma * sigma);
  }
  [[nodiscard]] double rms() const { return std::sqrt(squares / count); }
};

// What a sigma may be that of.
enum class SigmaKind : std::uint8_t { kMagnitude, kVector, kAxis };

// Makes the card of one tool: each member adds its lines.
class CardMaker {
 public:
  CardMaker(std::vector<MatchedState> matched, const SetUp& set_up, ForceCard* card)
      : matched_(std::move(matched)), set_up_(set_up), card_(*card) {
    ChooseAxes();
    Sort();
  }

  void AddForce();
  void AddSigma();

 private:
  void ChooseAxes();
  void Sort();
  void SplitByLoad();
  [[nodiscard]] bool IsLoaded(const MatchedState& one) const {
    return largest_ > 0 && OnAxes(one.known.force).norm() >= kLoadedShare * largest_;
  }
  void AddDelay(ForceRecord* record);
  void FitForce(const ForceRecord& record);
  void DivideByUnit(double gain);
  void AddUnit();
  void AddZero();
  void AddOffset(const ForceRecord& record);
  void AddMagnitude();
  void AddDirections();
  void AddChange(ForceRecord* record);
  void AddSizes(const ForceRecord& record);
  void FitLoads();
  [[nodiscard]] ForceRecord Record() const;
  [[nodiscard]] Scale ScaleOf(int known_axis) const;
  [[nodiscard]] SigmaCheck CheckSigma(SigmaKind kind, bool corrected) const;
  [[nodiscard]] Vector3d OnAxes(const Vector3d& vector) const;
  [[nodiscard]] Vector3d Error(const MatchedState& one) const {
    return OnAxes(one.state.force) - OnAxes(one.known.force);
  }
  CardLine& Add(std::string key, std::string title) {
    return card_.lines.emplace_back(
        CardLine{std::move(key), std::move(title), Finding::kUntested, {}, {}, {}});
  }

  std::vector<MatchedState> matched_;  // forces divided by the unit, known ones moved by the delay
  const SetUp& set_up_;
  ForceCard& card_;
  double largest_ = 0;                       // known force [N]
  std::vector<MatchedState*> compared_;      // in order of the record
  std::vector<const MatchedState*> loaded_;  // of them, under load
  std::vector<const MatchedState*> unloaded_;
  Vector3d offset_{0, 0, 0};          // of the unloaded force, where that is wrong [N]
  Matrix3d map_ = Matrix3d::Zero();   // what the force would be without noise: map_ known + offset_
  Vector3d drift_rate_{0, 0, 0};      // of a record whose drift is wrong [N/s]
  double drift_from_ = 0;             // [s]
  std::optional<RecordMap> map_fit_;  // of a record
};

Vector3d CardMaker::OnAxes(const Vector3d& vector) const {
  Vector3d on = Vector3d::Zero();
  for (const int axis : card_.axes) on(axis) = vector(axis);
  return on;
}

// Those that every known force has, and some reported force.
void CardMaker::ChooseAxes() {
  for (const int axis : {0, 1, 2}) {
    if (axis == 2 && set_up_.is_planar) continue;
    bool is_known = false, is_missing = false, is_reported = set_up_.has_scene;
    for (const MatchedState& one : matched_) {
      if (std::isfinite(one.state.force(axis))) is_reported = true;
      if (!one.known.force.array().isFinite().any()) continue;  // a press of known depth
      (std::isfinite(one.known.force(axis)) ? is_known : is_missing) = true;
    }
    if (is_known && !is_missing && is_reported) card_.axes.push_back(axis);
  }
}

void CardMaker::Sort() {
  for (MatchedState& one : matched_) {
    const bool is_compared = !card_.axes.empty() && OnAxes(one.known.force).allFinite() &&
                             one.known.force.array().isFinite().any() &&
                             OnAxes(one.state.force).allFinite();
    if (is_compared) compared_.push_back(&one);
    if (is_compared) largest_ = std::fmax(largest_, OnAxes(one.known.force).norm());
  }
  const auto is_loaded = [&](const MatchedState* one) { return IsLoaded(*one); };
  const auto loaded = std::ranges::count_if(compared_, is_loaded);
  const auto valid = std::ranges::count_if(
      compared_, [&](const auto* one) { return IsLoaded(*one) && one->state.is_valid; });
  card_.flagged = static_cast<int>(loaded - valid);
  // Flagged states count only where they are the rule.
  if (valid > card_.flagged) {
    std::erase_if(compared_,
                  [&](const auto* one) { return IsLoaded(*one) && !one->state.is_valid; });
  }
  SplitByLoad();
  card_.states = static_cast<int>(loaded_.size());
}

void CardMaker::SplitByLoad() {
  loaded_.clear();
  unloaded_.clear();
  for (const MatchedState* one : compared_) (IsLoaded(*one) ? loaded_ : unloaded_).push_back(one);
}

ForceRecord CardMaker::Record() const {
  const auto n = static_cast<Index>(compared_.size());
  ForceRecord record{Eigen::VectorXd(n), Eigen::Matrix3Xd(3, n), Eigen::Matrix3Xd(3, n)};
  for (Index i = 0; i < n; ++i) {
    const MatchedState& one = *compared_[static_cast<std::size_t>(i)];
    record.t(i) = one.state.t;
    record.known.col(i) = OnAxes(one.known.force);
    record.reported.col(i) = OnAxes(one.state.force);
  }
  if (!record.t.allFinite()) record.t.resize(0);
  return record;
}

void CardMaker::DivideByUnit(double gain) {
  card_.unit = UnitOf(gain).factor;
  for (MatchedState* one : compared_) one->state.force /= card_.unit;
  for (MatchedState* one : compared_) one->state.sigma /= card_.unit;
}

void CardMaker::FitLoads() {
  card_.loads.clear();
  for (const auto& [load, states] : ByLoad(loaded_)) {
    card_.loads.push_back(MeanOf(
        states, [&](const MatchedState& one) { return OnAxes(one.known.force); },
        [&](const MatchedState& one) -> Vector3d { return OnAxes(one.state.force) - offset_; }));
  }
  card_.force = FitMap(card_.loads, card_.axes);
}

void CardMaker::FitForce(const ForceRecord& record) {
  map_fit_ = FitRecord(record, card_.axes);
  card_.force = map_fit_->forth;
}

void CardMaker::AddForce() {
  if (!set_up_.is_record) {
    FitLoads();
    if (card_.force.is_decided) DivideByUnit(card_.force.gain.value);
    AddZero();
    FitLoads();
    AddUnit();
    AddMagnitude();
    AddDirections();
    return;
  }
  if (compared_.empty()) {  // there is nothing to fit
    AddUnit();
    AddMagnitude();
    AddDirections();
    return;
  }
  ForceRecord record = Record();
  AddDelay(&record);
  AddChange(&record);
  FitForce(record);
  if (card_.force.is_decided && map_fit_->back.is_decided) {
    DivideByUnit(std::sqrt(card_.force.gain.value / map_fit_->back.gain.value));
    record.reported /= card_.unit;
    drift_rate_ /= card_.unit;
    FitForce(record);
  }
  AddUnit();
  AddMagnitude();
  AddDirections();
  AddOffset(record);
  AddSizes(record);
}

void CardMaker::AddDelay(ForceRecord* record) {
  CardLine& line = Add("delay", "Delay");
  const auto delay = EstimateDelay(*record);
  if (!delay) {
    line.remark = record->t.size() == 0 ? "the record has no time" : "the record does not tell it";
    return;
  }
  const double duration = record->t(record->t.size() - 1) - record->t(0);
  constexpr double kShortest = 0.005;  // [s]
  const double tolerance =
      std::fmax(kShortest, duration / static_cast<double>(record->t.size() - 1));
  line.interval = delay;
  line.value = Words(*delay, " ms", 1e3, 1);
  line.remark = Formatted("right is at most one sample, %.3g ms", 1e3 * tolerance);
  line.finding = Judged(*delay, -tolerance, tolerance);
  if (line.finding != Finding::kWrong) return;
  std::vector<std::size_t> kept(compared_.size());
  std::iota(kept.begin(), kept.end(), 0);
  MoveKnown(delay->value, record, &kept);
  std::vector<MatchedState*> moved;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    moved.push_back(compared_[kept[i]]);
    for (const int axis : card_.axes) {
      moved.back()->known.force(axis) = record->known(axis, static_cast<Index>(i));
    }
  }
  compared_ = std::move(moved);
  SplitByLoad();
}

void CardMaker::AddUnit() {
  CardLine& line = Add("unit", "Unit");
  if (!card_.force.is_decided) return;
  const UnitMistake mistake = UnitOf(card_.unit);
  line.finding = mistake.factor == 1 ? Finding::kRight : Finding::kWrong;
  line.value = Formatted("%.4g", mistake.factor);
  line.remark = "factor of a unit between reported and known forces, 1 is right";
}

void CardMaker::AddZero() {
  CardLine& line = Add("zero", "Force without a load");
  std::vector<Vector3d> errors;
  for (const MatchedState* one : unloaded_) errors.push_back(Error(*one));
  const auto mean = MeanError(errors);
  if (!mean || !(largest_ > 0)) {
    line.remark = "no load of zero was held";
    return;
  }
  line.interval = mean->second;
  line.value = Words(*line.interval, " N", 1, 4);
  line.remark = Formatted("right is at most %.3g N, %g %% of the largest load",
                          kZeroTolerance * largest_, 100 * kZeroTolerance);
  line.finding = Judged(*line.interval, 0, kZeroTolerance * largest_);
  if (line.finding == Finding::kWrong) offset_ = mean->first;
}

// The force that is reported without a load, by the map: with the right scale and frame it is the
// mean error, else the smaller one of both fits.
void CardMaker::AddOffset(const ForceRecord& record) {
  CardLine& line = Add("zero", "Offset");
  std::vector<Matrix3d> maps{card_.force.relation.matrix()};
  const bool is_right = card_.line("magnitude").finding == Finding::kRight &&
                        card_.line("frame").finding == Finding::kRight;
  if (!is_right) {
    const Matrix3d back = map_fit_->back.map;
    maps = {card_.force.map};
    maps.emplace_back(back.completeOrthogonalDecomposition().pseudoInverse());
  }
  std::optional<std::pair<Vector3d, Interval>> least;
  for (const Matrix3d& map : maps) {
    std::vector<Vector3d> errors;
    for (Index i = 0; i < record.known.cols(); ++i) {
      errors.emplace_back(record.reported.col(i) - map * record.known.col(i));
    }
    const auto mean = MeanError(errors);
    if (mean && (!least || mean->second.value < least->second.value)) least = mean, map_ = map;
  }
  if (!least) return;
  line.interval = least->second;
  line.value = Words(*line.interval, " N", 1, 4);
  line.remark = Formatted("right is at most %.3g N, %g %% of the largest force",
                          kZeroTolerance * largest_, 100 * kZeroTolerance);
  line.finding = Judged(*line.interval, 0, kZeroTolerance * largest_);
  offset_ = least->first;
}

Scale CardMaker::ScaleOf(int known_axis) const {
  const auto j = static_cast<std::size_t>(known_axis);
  const Interval forth = *card_.force.axis_gain[j];
  if (!map_fit_ || !map_fit_->back.is_decided) return {forth, forth};
  const auto& back =
      map_fit_->back.axis_gain[static_cast<std::size_t>(card_.force.relation.axis[j])];
  return {forth, back ? Inverse(*back) : forth};
}

void CardMaker::AddMagnitude() {
  CardLine& line = Add("magnitude", "Force magnitude");
  const MapFit& fit = card_.force;
  if (fit.directions == 0) {
    line.remark = "no state has a force under a known force";
    if (!loaded_.empty()) {
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
  const bool both = map_fit_ && map_fit_->back.is_decided;
  const Scale scale{fit.gain, both ? Inverse(map_fit_->back.gain) : fit.gain};
  line.interval = scale.Both();
  line.value = Words(*line.interval);
  const double tolerance = set_up_.is_record ? kRecordTolerance : kForceTolerance;
  line.finding = scale.Judge(tolerance);
  line.remark = Formatted("reported / known, right is %g to %g", 1 - tolerance, 1 + tolerance);
  for (int j = 0; j < 3; ++j) {
    if (!fit.axis_gain[static_cast<std::size_t>(j)]) continue;
    const Scale of_axis = ScaleOf(j);
    line.remark +=
        std::string("; ") + kAxisNames[static_cast<std::size_t>(j)] + ": " + Words(of_axis.Both());
    // The worse one of the axes counts: wrong, then open, which the scatter of a record may be.
    const Finding finding = of_axis.Judge(tolerance);
    if (finding == Finding::kWrong) line.finding = finding;
    if (finding == Finding::kOpen && line.finding == Finding::kRight && !map_fit_) {
      line.finding = finding;
    }
  }
}

void CardMaker::AddDirections() {
  const MapFit& fit = card_.force;
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
      // The scatter of a record widens the interval of a turn, which is never negative.
      const bool is_small = map_fit_ && fit.turn.value <= kTurnTolerance;
      frame.finding = fit.relation.is_permuted() ? Finding::kWrong
                      : is_small                 ? Finding::kRight
                                                 : Judged(fit.turn, 0, kTurnTolerance);
      if (fit.relation.is_permuted() || fit.relation.is_flipped()) {
        const std::string words = RelationWords(fit.relation, card_.axes);
        (fit.relation.is_permuted() ? frame : sign).remark += "; " + words;
      }
    }
  }
  card_.lines.push_back(std::move(sign));
  card_.lines.push_back(std::move(frame));
}

// A drift that is wrong is removed, from the first row on.
void CardMaker::AddChange(ForceRecord* record) {
  const RecordChange change = FitChange(*record);
  // In the unit of the reported force.
  const double largest = record->reported.colwise().norm().maxCoeff();
  const auto add = [&](const char* key, const char* title, const std::optional<Interval>& size,
                       const char* what) {
    CardLine& line = Add(key, title);
    line.remark = "the record does not tell it";
    if (!size) return line.finding;
    line.interval = size;
    line.value = Words(*size, " N", 1, 4);
    line.remark = Formatted("%s, right is at most %.3g N", what, kChangeTolerance * largest);
    line.finding = Judged(*size, 0, kChangeTolerance * largest);
    if (line.finding == Finding::kOpen) line.finding = Finding::kUntested;
    return line.finding;
  };
  if (add("time", "Drift", change.drift, "change of the error during the record") ==
      Finding::kWrong) {
    const Eigen::RowVectorXd share = (record->t.array() - record->t(0)).matrix().transpose() /
                                     (record->t(record->t.size() - 1) - record->t(0));
    record->reported -= change.drift_vector * share;
    drift_from_ = record->t(0);
    drift_rate_ = change.drift_vector / (record->t(record->t.size() - 1) - drift_from_);
  }
  add("hysteresis", "Hysteresis", change.hysteresis,
      "how much the error differs between loading and unloading");
}

// Mean errors of five ranges of size, of equally many rows.
void CardMaker::AddSizes(const ForceRecord& record) {
  CardLine& line = Add("size", "Error by size");
  constexpr std::size_t kRanges = 5, kFewest = 10;
  std::vector<Index> order(static_cast<std::size_t>(record.known.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](Index i) { return record.known.col(i).norm(); });
  if (order.size() < kRanges * kFewest) return;
  for (std::size_t range = 0; range < kRanges; ++range) {
    std::vector<Index> rows(
        order.begin() + static_cast<long>(range * order.size() / kRanges),
        order.begin() + static_cast<long>((range + 1) * order.size() / kRanges));
    const double from = record.known.col(rows.front()).norm();
    const double until = record.known.col(rows.back()).norm();
    std::ranges::sort(rows);  // neighbours share errors
    std::vector<Vector3d> errors;
    for (const Index i : rows) {
      errors.emplace_back(record.reported.col(i) - map_ * record.known.col(i) - offset_);
    }
    const auto mean = MeanError(errors);
    if (line.interval && mean->second.value <= line.interval->value) continue;
    line.interval = mean->second;
    line.value = Words(mean->second, " N", 1, 4);
    line.remark = Formatted("largest mean error beside scale and offset: forces of %.3g to %.3g N",
                            from, until);
  }
  line.finding = Judged(*line.interval, 0, kChangeTolerance * largest_);
  if (line.finding == Finding::kOpen) line.finding = Finding::kRight;
}

SigmaCheck CardMaker::CheckSigma(SigmaKind kind, bool corrected) const {
  SigmaCheck check;
  for (const MatchedState* one : loaded_) {
    const double sigma =
        std::fmax(std::hypot(one->state.sigma, set_up_.has_scene ? one->known.sigma_or_usual() : 0),
                  1e-6 * largest_);
    Vector3d known = OnAxes(one->known.force), reported = OnAxes(one->state.force);
    if (corrected) {
      known = map_ * known + offset_;
      if (!drift_rate_.isZero()) reported -= drift_rate_ * (one->state.t - drift_from_);
    }
    const Vector3d error = reported - known;
    if (kind == SigmaKind::kVector) check.Add(error.norm(), sigma);
    if (kind == SigmaKind::kMagnitude) check.Add(std::abs(reported.norm() - known.norm()), sigma);
    for (const int axis : card_.axes) {
      if (kind == SigmaKind::kAxis) check.Add(std::abs(error(axis)), sigma);
    }
  }
  return check;
}

void CardMaker::AddSigma() {
  CardLine& line = Add("sigma", "Sigma");
  const auto loads = map_fit_
                         ? static_cast<int>(static_cast<double>(loaded_.size()) / map_fit_->repeats)
                         : static_cast<int>(ByLoad(loaded_).size());
  if (loads == 0) {
    line.remark = "no state has a force under a known force";
    return;
  }
  if (!set_up_.has_scene && std::ranges::all_of(loaded_, [](const MatchedState* one) {
        return !(one->state.sigma > 0);
      })) {
    line.remark = "the record has no sigma";
    return;
  }
  SigmaKind kind = set_up_.sigma_of_vector ? SigmaKind::kVector : SigmaKind::kMagnitude;
  if (!set_up_.has_scene) {  // the kind that fits best
    kind = std::ranges::min({SigmaKind::kAxis, SigmaKind::kVector}, {}, [&](SigmaKind one) {
      return std::abs(std::log(CheckSigma(one, false).rms()));
    });
  }
  // A unit's mistake may concern the force alone.
  const double ratio = CheckSigma(kind, false).rms();
  if (!set_up_.has_scene && std::abs(std::log(ratio / card_.unit)) < std::abs(std::log(ratio))) {
    for (MatchedState* one : compared_) one->state.sigma *= card_.unit;
  }
  const SigmaCheck check = CheckSigma(kind, false);
  const Interval within_one = ShareInterval(check.within_one / check.count, loads);
  const Interval within_two = ShareInterval(check.within_two / check.count, loads);
  line.interval = within_two;
  line.value = "within 1 sigma " + Words(within_one, " %", 100, 0) + ", within 2 sigma " +
               Words(within_two, " %", 100, 0);
  constexpr double kWithinOne = 0.683, kWithinTwo = 0.954;
  // An error that all loads share, as that of a modulus, may be two sigma of one load in twenty
  // set-ups. Errors that are not larger than this are no proof.
  constexpr double kTooLarge = 1.6, kCautious = 0.4;
  const double rms = check.rms();
  const bool is_too_small = within_two.high < kWithinTwo && rms > kTooLarge;
  const bool is_too_large = within_one.low > kWithinOne && rms < kCautious;
  line.finding =
      is_too_small || (is_too_large && !set_up_.has_scene) ? Finding::kWrong : Finding::kRight;
  line.remark = Formatted("expected 68 %% and 95 %%; errors are %.2g sigma rms", rms);
  if (line.finding == Finding::kRight && within_one.high < kWithinOne) {
    line.remark += "; fewer than expected are within 1 sigma, as with one error of all loads";
  }
  if (rms < kCautious) line.remark += "; sigma is larger than these errors need";
  card_.sigma_ratio = rms;
  if (map_fit_) card_.corrected_sigma_ratio = CheckSigma(kind, true).rms();
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
  maker.AddForce();
  maker.AddSigma();
  if (set_up.has_scene) AddPosition(matched, set_up, &card);
  card.causes = CausesOf(card, set_up);
  return card;
}

}  // namespace palpate
