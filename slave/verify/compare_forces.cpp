#include "slave/verify/compare_forces.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"
#include "slave/statistics/robust.h"
#include "slave/verify/compare_text.h"
#include "slave/verify/record_fit.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLoadedShare = 0.05;  // of the largest measured force

// The quantity to which a sigma refers.
enum class SigmaKind : std::uint8_t { kMagnitude, kVector, kAxis };

// Returns the mean of the columns of each hold; columns of one hold are contiguous.
Matrix3Xd MeansOfHolds(const Matrix3Xd& columns, const std::vector<const ForceRow*>& rows) {
  Matrix3Xd means(3, columns.cols());
  Index count = 0;
  for (std::size_t from = 0, until = 0; from < rows.size(); from = until) {
    while (until < rows.size() && rows[until]->hold == rows[from]->hold) ++until;
    const auto first = static_cast<Index>(from), length = static_cast<Index>(until - from);
    means.col(count++) = columns.middleCols(first, length).rowwise().mean();
  }
  return means.leftCols(count);
}

// Two columns of vectors, restricted to axes on which some row has numbers in both.
struct Columns {
  std::vector<int> axes;
  std::vector<const ForceRow*> rows;  // rows with numbers on all of these axes
  Matrix3Xd first, second;            // 0 on other axes
};

Columns ColumnsOf(const std::vector<ForceRow>& rows, Vector3d ForceRow::*first,
                  Vector3d ForceRow::*second) {
  Columns columns;
  for (int axis = 0; axis < 3; ++axis) {
    const auto is_known = [&](const ForceRow& row) {
      return std::isfinite((row.*first)(axis) + (row.*second)(axis));
    };
    if (std::ranges::any_of(rows, is_known)) columns.axes.push_back(axis);
  }
  const auto is_complete = [&](const ForceRow& row) {
    return !columns.axes.empty() && (row.*first + row.*second)(columns.axes).allFinite();
  };
  for (const ForceRow& row : rows) {
    if (is_complete(row)) columns.rows.push_back(&row);
  }
  columns.first = columns.second = Matrix3Xd::Zero(3, static_cast<Index>(columns.rows.size()));
  for (std::size_t i = 0; i < columns.rows.size(); ++i) {
    for (const int axis : columns.axes) {
      columns.first(axis, static_cast<Index>(i)) = (columns.rows[i]->*first)(axis);
      columns.second(axis, static_cast<Index>(i)) = (columns.rows[i]->*second)(axis);
    }
  }
  return columns;
}

template <class Value>
std::vector<Value> Selected(const std::vector<Value>& values, const std::vector<Index>& rows) {
  std::vector<Value> selected;
  for (const Index row : rows) selected.push_back(values[static_cast<std::size_t>(row)]);
  return selected;
}

// Each member adds its lines.
class Comparer {
 public:
  Comparer(const std::vector<ForceRow>& all, const ForceSource& source)
      : all_(all), source_(source) {
    Columns columns = ColumnsOf(all, &ForceRow::measured, &ForceRow::estimated);
    result_.axes = std::move(columns.axes);
    rows_ = std::move(columns.rows);
    record_ = {VectorXd(static_cast<Index>(rows_.size())), std::move(columns.first),
               std::move(columns.second)};
    if (rows_.empty()) return;
    for (std::size_t i = 0; i < rows_.size(); ++i) record_.t(static_cast<Index>(i)) = rows_[i]->t;
    if (!record_.t.allFinite()) record_.t.resize(0);
    for (const ForceRow* row : rows_) sigma_.push_back(row->sigma);
    largest_ = record_.measured.colwise().norm().maxCoeff();
    largest_estimate_ = record_.estimated.colwise().norm().maxCoeff();
    LeaveOutFlagged();
  }

  ForceComparison Run();

 private:
  void Keep(const std::vector<Index>& rows);
  void LeaveOutFlagged();
  [[nodiscard]] bool is_record() const { return all_.empty() || all_[0].hold < 0; }
  [[nodiscard]] double tolerance() const {
    return is_record() ? kRecordTolerance : kForceTolerance;
  }
  [[nodiscard]] bool IsLoaded(Index i) const {
    return largest_ > 0 && record_.measured.col(i).norm() >= kLoadedShare * largest_;
  }
  // The estimate of the largest measured force, if the scale of estimates is above 1 [N].
  [[nodiscard]] double LargestExpected() const {
    return largest_ * std::fmax(1, result_.map.gain.forth.value);
  }
  void AddRate();
  void AddDelay();
  void AddChannels();
  void AddChange();
  void AddUnit();
  void AddMagnitude();
  void AddDirections();
  void AddOffset();
  void AddSizes();
  void AddSigma();
  void AddPosition();
  void Fit();
  [[nodiscard]] VectorXd SigmaErrors(SigmaKind kind, bool corrected) const;
  ComparisonLine& Add(std::string key, std::string title) {
    return result_.lines.emplace_back(ComparisonLine{std::move(key), std::move(title)});
  }

  const std::vector<ForceRow>& all_;
  const ForceSource& source_;
  ForceComparison result_;
  std::vector<const ForceRow*> rows_;  // compared rows
  // The compared rows, with estimates converted to the unit and measured forces shifted in time.
  ForceRecord record_;
  std::vector<double> sigma_;
  double largest_ = 0;               // measured force [N]
  double largest_estimate_ = 0;      // in its own unit [N]
  ForceRecord fitted_;               // means of holds, or the record without drift
  std::vector<int> block_;           // block of each column of fitted_
  Vector3d drift_{0, 0, 0};          // drift of the record if it is wrong [N]
  Vector3d offset_{0, 0, 0};         // [N]
  Matrix3d map_ = Matrix3d::Zero();  // fitted relation: estimate = map_ measured + offset_
};

// Keeps only these compared rows.
void Comparer::Keep(const std::vector<Index>& rows) {
  if (record_.t.size() > 0) record_.t = VectorXd(record_.t(rows));
  record_.measured = Matrix3Xd(record_.measured(Eigen::all, rows));
  record_.estimated = Matrix3Xd(record_.estimated(Eigen::all, rows));
  rows_ = Selected(rows_, rows);
  sigma_ = Selected(sigma_, rows);
}

// Leaves out flagged rows, unless most rows are flagged.
void Comparer::LeaveOutFlagged() {
  std::vector<Index> kept;
  Index loaded = 0;
  for (Index i = 0; i < record_.measured.cols(); ++i) {
    const bool is_valid = rows_[static_cast<std::size_t>(i)]->is_valid;
    loaded += IsLoaded(i) ? 1 : 0;
    if (is_valid || !IsLoaded(i)) kept.push_back(i);
    if (!is_valid && IsLoaded(i)) ++result_.flagged;
  }
  if (loaded > 2 * result_.flagged) Keep(kept);
}

void Comparer::AddRate() {
  const Index n = record_.t.size();
  if (n < kMinFitRows) return;
  constexpr double kFastest = 20e-6, kSlowest = 2;  // [s]
  std::vector<double> steps;
  for (Index i = 1; i < n; ++i) steps.push_back(record_.t(i) - record_.t(i - 1));
  const double step = MedianOf(steps);
  ComparisonLine& line = Add("rate", "Time between rows");
  line.value = Formatted("%.4g s", step);
  line.remark = Formatted("right is %g us to %g s", 1e6 * kFastest, kSlowest);
  line.finding = step < kFastest || step > kSlowest ? Judgement::kWrong : Judgement::kRight;
}

void Comparer::AddDelay() {
  ComparisonLine& line = Add("delay", "Delay");
  const auto delay = EstimateDelay(record_);
  if (!delay) {
    line.remark =
        record_.t.size() == 0 ? "the record has no time" : "the record does not determine it";
    return;
  }
  const Index n = record_.t.size();
  constexpr double kMinTolerance = 0.005;  // [s]
  const double sample = (record_.t(n - 1) - record_.t(0)) / static_cast<double>(n - 1);
  const double tolerance = std::fmax(kMinTolerance, sample);
  line.interval = delay;
  line.value = Words(*delay, " ms", 1e3, 1);
  line.remark = Formatted("right is at most one sample, %.3g ms", 1e3 * tolerance);
  line.finding = FindingOfInterval(*delay, -tolerance, tolerance);
  if (line.finding != Judgement::kWrong) return;
  const std::vector<Index> kept = MoveMeasured(delay->value, &record_);
  rows_ = Selected(rows_, kept);
  sigma_ = Selected(sigma_, kept);
}

// An estimate that keeps its value while the measured force changes by a fifth of the largest one:
// a dead channel, a stuck value, or saturation. An axis where that holds of most rows is left out,
// otherwise the rows.
void Comparer::AddChannels() {
  ComparisonLine& line = Add("channel", "Channels");
  if (!(largest_ > 0)) return;
  constexpr double kChange = 0.2;
  constexpr Index kMinRun = 5;
  const Index n = record_.measured.cols();
  line.finding = Judgement::kRight;
  std::vector<bool> is_stuck(static_cast<std::size_t>(n), false);
  for (const int axis : std::vector(result_.axes)) {
    const auto measured = record_.measured.row(axis), estimated = record_.estimated.row(axis);
    std::set<double> values;
    for (Index from = 0, until = 0; from < n; from = until) {
      while (until < n && estimated(until) == estimated(from)) ++until;
      const auto run = measured.segment(from, until - from);
      if (until - from < kMinRun) continue;
      if (run.maxCoeff() - run.minCoeff() > kChange * largest_) values.insert(estimated(from));
    }
    if (values.empty()) continue;
    Index stuck = 0;
    for (Index i = 0; i < n; ++i) {
      if (!values.contains(estimated(i))) continue;
      is_stuck[static_cast<std::size_t>(i)] = true;
      ++stuck;
    }
    line.finding = Judgement::kWrong;
    line.value += (line.value.empty() ? "" : "; ") +
                  Formatted("%s stays at %.4g N in %.0f %% of the rows",
                            kAxisNames[static_cast<std::size_t>(axis)], *values.begin(),
                            100.0 * static_cast<double>(stuck) / static_cast<double>(n));
    if (2 * stuck <= n) continue;
    std::erase(result_.axes, axis);
    record_.measured.row(axis).setZero();
    record_.estimated.row(axis).setZero();
    std::fill(is_stuck.begin(), is_stuck.end(), false);
  }
  line.remark =
      Formatted("right is no constant estimate while the measured force changes by %.3g N",
                kChange * largest_);
  std::vector<Index> kept;
  for (Index i = 0; i < n; ++i) {
    if (!is_stuck[static_cast<std::size_t>(i)]) kept.push_back(i);
  }
  Keep(kept);
}

// Subtracts the drift if it is wrong.
void Comparer::AddChange() {
  const RecordChange change = FitChange(record_);
  const double right = kChangeTolerance * largest_estimate_;
  const auto add = [&](const char* key, const char* title, const std::optional<Interval>& size,
                       const char* what) {
    ComparisonLine& line = Add(key, title);
    line.remark = "the record does not determine it";
    if (!size) return line.finding;
    line.interval = size;
    line.value = Words(*size, " N", 1, 4);
    line.remark = Formatted("%s, right is at most %.3g N", what, right);
    line.finding = FindingOfInterval(*size, 0, right);
    if (line.finding == Judgement::kOpen) line.finding = Judgement::kUntested;
    return line.finding;
  };
  if (add("time", "Drift", change.drift, "change of the error during the record") ==
      Judgement::kWrong) {
    drift_ = change.drift_vector;
  }
  add("hysteresis", "Hysteresis", change.hysteresis,
      "how much the error differs between loading and unloading");
}

void Comparer::Fit() {
  fitted_ = record_;
  if (is_record()) {
    block_ = BlocksOf(record_.measured.cols());
    if (!drift_.isZero()) {
      const auto share =
          (record_.t.array() - record_.t(0)) / (record_.t(record_.t.size() - 1) - record_.t(0));
      fitted_.estimated -= drift_ * share.matrix().transpose();
    }
  } else {
    fitted_ = {{}, MeansOfHolds(record_.measured, rows_), MeansOfHolds(record_.estimated, rows_)};
    block_.resize(static_cast<std::size_t>(fitted_.measured.cols()));
    std::iota(block_.begin(), block_.end(), 0);
    result_.holds = static_cast<int>(block_.size());
  }
  result_.map = FitMap(fitted_.measured, fitted_.estimated, block_, result_.axes);
}

void Comparer::AddUnit() {
  ComparisonLine& line = Add("unit", "Unit");
  line.remark = "factor of a unit between estimated and measured forces, 1 is right";
  if (!result_.map.is_decided) return;
  constexpr double kClose = 1.5;
  const Interval gain = result_.map.gain.Both();
  const UnitMistake mistake = result_.map.gain.FindingWithin(tolerance()) == Judgement::kWrong
                                  ? UnitOf(gain)
                                  : UnitMistake{};
  line.value = Formatted("%.4g", mistake.factor);
  line.finding = mistake.factor != 1                              ? Judgement::kWrong
                 : gain.value < kClose && gain.value > 1 / kClose ? Judgement::kRight
                                                                  : Judgement::kUntested;
  if (line.finding == Judgement::kUntested) {
    line.value.clear();
    line.remark = "no unit has this scale";
  }
  if (mistake.factor == 1) return;
  result_.unit = mistake.factor;
  record_.estimated /= result_.unit;
  drift_ /= result_.unit;
  for (double& sigma : sigma_) sigma /= result_.unit;
  Fit();
}

void Comparer::AddMagnitude() {
  ComparisonLine& line = Add("magnitude", "Force magnitude");
  const VectorMap& map = result_.map;
  if (map.directions == 0) {
    line.remark = "no state has a force under a known force";
    if (result_.rows == 0) return;
    const bool is_zero = largest_estimate_ == 0;
    const bool is_constant = result_.line("channel").finding == Judgement::kWrong;
    line.remark = is_zero       ? "the reported force is zero under every load"
                  : is_constant ? "the reported force does not change"
                                : "the forces do not change";
    if (is_zero || is_constant) line.finding = Judgement::kWrong;
    return;
  }
  if (!map.is_decided) {
    line.finding = Judgement::kOpen;
    line.remark = Formatted("%zu loads in %d directions: hold at least %d loads", block_.size(),
                            map.directions, map.directions + 3);
    return;
  }
  line.interval = map.gain.Both();
  line.value = Words(*line.interval);
  line.finding = map.gain.FindingWithin(tolerance());
  line.remark = Formatted("reported / known, right is %g to %g", 1 - tolerance(), 1 + tolerance());
  for (std::size_t j = 0; j < 3; ++j) {
    if (!map.axis_gain[j]) continue;
    line.remark += std::string("; ") + kAxisNames[j] + ": " + Words(map.axis_gain[j]->Both());
    if (map.axis_gain[j]->FindingWithin(tolerance()) == Judgement::kWrong)
      line.finding = Judgement::kWrong;
  }
}

void Comparer::AddDirections() {
  const VectorMap& map = result_.map;
  const Judgement unknown = map.directions == 0 ? Judgement::kUntested : Judgement::kOpen;
  ComparisonLine sign{"sign", "Sign", unknown}, frame{"frame", "Frame", unknown};
  if (map.is_decided) {
    sign.interval = map.along;
    sign.value = Words(map.along, "", 1, 2);
    sign.remark = "cosine of reported and known force, 1 is right, -1 is reversed";
    frame.interval = map.turn;
    frame.value = Words(map.turn, " deg", 1 / kDegree, 1);
    frame.remark = Formatted("turn, right is at most %.0f deg", kTurnTolerance / kDegree);
    std::vector<int> tested;
    for (int axis = 0; axis < 3; ++axis) {
      if (map.axis_gain[static_cast<std::size_t>(axis)]) tested.push_back(axis);
    }
    frame.remark += tested.empty() ? "; loads in one oblique direction"
                                   : "; tested by loads along " + AxisNames(tested);
    const AxisRelation& relation = map.relation;
    if (map.relation_is_clear) {
      sign.finding = relation.is_flipped() ? Judgement::kWrong : Judgement::kRight;
      // An angle is never negative, so scatter increases it and its interval.
      const bool is_small = map.turn.value <= kTurnTolerance;
      frame.finding = relation.is_permuted() ? Judgement::kWrong
                      : is_small             ? Judgement::kRight
                                             : FindingOfInterval(map.turn, 0, kTurnTolerance);
      if (relation.is_permuted() || relation.is_flipped()) {
        (relation.is_permuted() ? frame : sign).remark +=
            "; " + RelationWords(relation, result_.axes);
      }
    }
  }
  result_.lines.push_back(std::move(sign));
  result_.lines.push_back(std::move(frame));
}

// Determines the force that is estimated without a load: the smallest one by both regressions, and
// by the mean error if scale and frame are right, because a prediction that tends to its mean has
// no offset.
void Comparer::AddOffset() {
  ComparisonLine& line = Add("zero", "Offset");
  if (result_.map.directions == 0) return;
  std::vector<Matrix3d> maps{result_.map.map, result_.map.inverse};
  if (result_.line("magnitude").finding == Judgement::kRight &&
      result_.line("frame").finding == Judgement::kRight) {
    maps.push_back(result_.map.relation.matrix());
  }
  for (const Matrix3d& map : maps) {
    const auto mean = MeanOf(fitted_.estimated - map * fitted_.measured);
    if (!mean || (line.interval && mean->size.value >= line.interval->value)) continue;
    line.interval = mean->size;
    offset_ = mean->mean;
    map_ = map;
  }
  if (!line.interval) return;
  const double right = kZeroTolerance * LargestExpected();
  line.value = Words(*line.interval, " N", 1, 4);
  line.remark =
      Formatted("right is at most %.3g N, %g %% of the largest force", right, 100 * kZeroTolerance);
  line.finding = FindingOfInterval(*line.interval, 0, right);
}

// Adds the mean errors of five ranges of force with equal numbers of rows.
void Comparer::AddSizes() {
  ComparisonLine& line = Add("size", "Error by size");
  constexpr std::size_t kRanges = 5;
  const VectorXd size = fitted_.measured.colwise().norm().transpose();
  if (size.size() < kMinFitRows || result_.map.directions == 0) return;
  const Matrix3Xd error = (fitted_.estimated - map_ * fitted_.measured).colwise() - offset_;
  std::vector<Index> order(static_cast<std::size_t>(size.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](Index i) { return size(i); });
  for (std::size_t range = 0; range < kRanges; ++range) {
    std::vector<Index> rows(
        order.begin() + static_cast<long>(range * order.size() / kRanges),
        order.begin() + static_cast<long>((range + 1) * order.size() / kRanges));
    const double from = size(rows.front()), until = size(rows.back());
    std::ranges::sort(rows);  // because neighbouring rows have correlated errors
    const auto mean = MeanOf(error(Eigen::all, rows));
    if (line.interval && mean->size.value <= line.interval->value) continue;
    line.interval = mean->size;
    line.value = Words(mean->size, " N", 1, 4);
    line.remark = Formatted("largest mean error beside scale and offset: forces of %.3g to %.3g N",
                            from, until);
  }
  line.finding = FindingOfInterval(*line.interval, 0, kChangeTolerance * LargestExpected());
  if (line.finding == Judgement::kOpen) line.finding = Judgement::kRight;
}

// Errors of the rows under load that have a sigma, in units of it.
VectorXd Comparer::SigmaErrors(SigmaKind kind, bool corrected) const {
  std::vector<double> errors;
  for (Index i = 0; i < record_.measured.cols(); ++i) {
    if (!IsLoaded(i) || !std::isfinite(sigma_[static_cast<std::size_t>(i)])) continue;
    const double sigma = std::fmax(sigma_[static_cast<std::size_t>(i)], 1e-6 * largest_);
    Vector3d measured = record_.measured.col(i), estimated = record_.estimated.col(i);
    if (corrected) measured = map_ * measured + offset_;
    if (corrected && is_record()) estimated = fitted_.estimated.col(i);
    const Vector3d error = (estimated - measured) / sigma;
    if (kind == SigmaKind::kVector) errors.push_back(error.norm());
    if (kind == SigmaKind::kMagnitude) {
      errors.push_back(std::abs(estimated.norm() - measured.norm()) / sigma);
    }
    for (const int axis : result_.axes) {
      if (kind == SigmaKind::kAxis) errors.push_back(std::abs(error(axis)));
    }
  }
  return Eigen::Map<VectorXd>(errors.data(), static_cast<Index>(errors.size()));
}

void Comparer::AddSigma() {
  ComparisonLine& line = Add("sigma", "Sigma");
  if (std::ranges::none_of(sigma_, [](double sigma) { return sigma > 0; }) ||
      SigmaErrors(SigmaKind::kVector, false).size() == 0) {
    line.remark = "no row under load has a sigma";
    return;
  }
  const auto rms_of = [&](SigmaKind kind, bool corrected) {
    return std::sqrt(SigmaErrors(kind, corrected).array().square().mean());
  };
  const bool is_any = source_.kind == ForceSource::Kind::kAny;
  SigmaKind kind =
      source_.kind == ForceSource::Kind::kCamera ? SigmaKind::kMagnitude : SigmaKind::kVector;
  if (is_any) {  // chooses the kind of sigma that fits best
    kind = std::ranges::min({SigmaKind::kAxis, SigmaKind::kVector}, {},
                            [&](SigmaKind one) { return std::abs(std::log(rms_of(one, false))); });
  }
  // The wrong unit may affect only the force and not the sigma.
  const double ratio = rms_of(kind, false);
  if (is_any && std::abs(std::log(ratio / result_.unit)) < std::abs(std::log(ratio))) {
    for (double& sigma : sigma_) sigma *= result_.unit;
  }
  const VectorXd errors = SigmaErrors(kind, false);
  const auto within = [&](double reach) {
    const auto count = static_cast<double>((errors.array() <= reach).count());
    return ShareInterval(count / static_cast<double>(errors.size()), block_.back() + 1);
  };
  const Interval within_one = within(1), within_two = within(2);
  line.interval = within_two;
  line.value = "within 1 sigma " + Words(within_one, " %", 100, 0) + ", within 2 sigma " +
               Words(within_two, " %", 100, 0);
  constexpr double kWithinOne = 0.683, kWithinTwo = 0.954;
  // An error that all loads share, as that of a modulus, may be two sigma of one load in twenty
  // set-ups. Errors that are not larger than this are no proof.
  constexpr double kTooLarge = 1.6, kCautious = 0.4;
  const double rms = rms_of(kind, false);
  const bool is_too_small = within_two.high < kWithinTwo && rms > kTooLarge;
  const bool is_too_large = within_one.low > kWithinOne && rms < kCautious;
  line.finding = is_too_small || (is_too_large && is_any) ? Judgement::kWrong : Judgement::kRight;
  line.remark = Formatted("expected 68 %% and 95 %%; errors are %.2g sigma rms", rms);
  if (line.finding == Judgement::kRight && within_one.high < kWithinOne) {
    line.remark += "; fewer than expected are within 1 sigma, as with one error of all loads";
  }
  if (rms < kCautious) line.remark += "; sigma is larger than these errors need";
  result_.sigma_ratio = rms;
  result_.corrected_sigma_ratio = rms_of(kind, true);
}

// Compares known and estimated positions like forces.
void Comparer::AddPosition() {
  ComparisonLine scale{"position", "Position scale"};
  std::vector<ForceRow> rows = all_;
  Columns columns = ColumnsOf(rows, &ForceRow::p_known, &ForceRow::p_estimated);
  const bool is_depth = columns.axes.empty();
  if (is_depth) {
    for (ForceRow& row : rows) row.p_known.x() = row.known_depth, row.p_estimated.x() = row.depth;
    columns = ColumnsOf(rows, &ForceRow::p_known, &ForceRow::p_estimated);
  }
  Matrix3Xd known = columns.first, estimated = columns.second;
  std::vector<int> block = BlocksOf(known.cols());
  if (!is_record()) {
    known = MeansOfHolds(known, columns.rows);
    estimated = MeansOfHolds(estimated, columns.rows);
    block.resize(static_cast<std::size_t>(known.cols()));
    std::iota(block.begin(), block.end(), 0);
  }
  if (known.cols() > 0 && !is_depth && source_.object_size > 0) {
    const Vector3d offset = (estimated - known).rowwise().mean();
    const double right = kPlaceTolerance * source_.object_size;
    ComparisonLine& place = Add("place", "Tip position");
    place.value =
        Formatted("%.3g mm beside the known one: (%.3g, %.3g, %.3g) mm", 1e3 * offset.norm(),
                  1e3 * offset.x(), 1e3 * offset.y(), 1e3 * offset.z());
    place.remark = Formatted("right is at most %.3g mm", 1e3 * right);
    place.finding = offset.norm() > right ? Judgement::kWrong : Judgement::kRight;
  }
  const VectorMap map = FitMap(known, estimated, block, columns.axes);
  if (map.directions == 0) {
    scale.remark = "no position or depth is known";
  } else if (!map.is_decided) {
    scale.finding = Judgement::kOpen;
    scale.remark =
        Formatted("%zu known positions: hold at least %d", block.size(), map.directions + 3);
  } else {
    const double low = 1 - kPositionTolerance, high = 1 + kPositionTolerance;
    scale.interval = map.gain.forth;
    scale.value = Words(map.gain.forth, "", 1, 4);
    scale.remark = Formatted("%s reported / known, right is %g to %g",
                             is_depth ? "change of depth" : "travel of the tip", low, high);
    scale.finding = FindingOfInterval(map.gain.forth, low, high);
    if (map.relation_is_clear && (map.relation.is_permuted() || map.relation.is_flipped())) {
      scale.finding = Judgement::kWrong;
      scale.remark += "; axes of positions: " + RelationWords(map.relation, columns.axes);
    } else if (!is_depth && map.turn.low > kTurnTolerance) {
      scale.finding = Judgement::kWrong;
      scale.remark += "; travel is turned by " + Words(map.turn, " deg", 1 / kDegree, 1);
    }
    result_.position = map;
  }
  result_.lines.push_back(std::move(scale));
}

ForceComparison Comparer::Run() {
  if (is_record()) AddRate();
  if (is_record()) AddDelay();
  for (Index i = 0; i < record_.measured.cols(); ++i) result_.rows += IsLoaded(i) ? 1 : 0;
  AddChannels();
  if (is_record()) AddChange();
  Fit();
  AddUnit();
  AddMagnitude();
  AddDirections();
  AddOffset();
  if (is_record()) AddSizes();
  AddSigma();
  if (source_.kind != ForceSource::Kind::kAny) AddPosition();
  result_.causes = CausesOf(result_, source_);
  return std::move(result_);
}

}  // namespace

std::string_view ToString(Judgement finding) {
  constexpr std::array<std::string_view, 4> kWords{"right", "wrong", "not decided", "not tested"};
  return kWords[static_cast<std::size_t>(finding)];
}

const ComparisonLine& ForceComparison::line(std::string_view key) const {
  const auto found = std::ranges::find(lines, key, &ComparisonLine::key);
  if (found == lines.end()) throw std::out_of_range("no line " + std::string(key));
  return *found;
}

bool ForceComparison::passes() const {
  return line("magnitude").finding == Judgement::kRight &&
         std::ranges::none_of(lines, [](const ComparisonLine& one) {
           return one.finding == Judgement::kWrong || one.finding == Judgement::kOpen;
         });
}

ForceComparison CompareForces(const std::vector<ForceRow>& rows, const ForceSource& source) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].t < rows[i - 1].t) {
      throw std::invalid_argument(Formatted(
          "t falls from %g to %g s: expected rows in order of time", rows[i - 1].t, rows[i].t));
    }
    if ((rows[i].hold < 0) != (rows[0].hold < 0)) {
      throw std::invalid_argument("hold: expected a number in every row, or in none");
    }
  }
  return Comparer(rows, source).Run();
}

}  // namespace palpate
