#include "slave/tactile/fingertip.h"

#include <cmath>
#include <utility>

#include "shared/statistics/robust.h"
#include "shared/telemetry/stopwatch.h"
#include "slave/tactile/network/network_weights.h"

namespace palpate {
namespace {

// Of networks that do not say their error: paper B, table I, rnn_21 [N].
const Eigen::Vector3d kPaperSigma{0.01807, 0.03107, 0.05171};
constexpr double kBeginShare = 0.5, kEndShare = 0.25;  // of the error's size
constexpr double kUnseenTouch = 3;                     // times the error: no electrode, yet a force
constexpr double kFollowing = 2, kDrifting = 0.2;      // of rest values while nothing is near [s]
// What rest values may be followed up to, averaged over some samples: more of both is a contact.
constexpr double kLevelling = 0.1;  // share of a sample in what is averaged over some
constexpr double kStillElectrode = 1, kStillPressure = 2;  // [counts]
constexpr double kFew = 4;  // times as much counts of a single electrode
// A step of all electrodes alike: at least so large [counts], and over their scatter about it.
constexpr double kStep = 3, kAlike = 3;
// Steps that come again and again leave what of them is below that; for about so many samples.
constexpr double kManySteps = 2.5, kStepsLast = 0.97;
constexpr double kBriskly = 0.3;       // likewise, over a few: of pressure and pace
constexpr double kStirs = 3;           // 0.02 N [counts]
constexpr double kRestSigmas = 2;      // that the pressure's rest value may be off, besides
constexpr double kQuietest = 0.8;      // times the usual noise; five real fingers: 0.83 to 1.17
constexpr double kFallen = 0.85;       // of the first noise; real fingers in a minute: 0.95 to 1.1
constexpr double kLag = 3;             // samples that a recurrent network's answer is late, about
constexpr double kPromptLag = 0.25;    // that another one's is
constexpr double kLeap = 0.5;          // of what changes unlike before, that may be an error
constexpr double kDisagrees = 2.5;     // standard deviations between pressure and electrodes
constexpr double kHardlyAgrees = 1.5;  // likewise: from where on it is less sure
constexpr double kMisfit = 1.6;        // over what there is in the mean
constexpr double kUsualScatter = 0.5;  // of the misfit of one sample
constexpr double kBelowRest = -8;      // five real fingers: -2 after a press [counts]
constexpr int kBelieved = 2;           // samples that may be missing, unflagged
constexpr double kRelease = 0.050, kMissing = 0.060;  // [s]

bool IsFinite(const FingerReading& reading) {
  return std::ranges::all_of(reading.electrodes, [](float x) { return std::isfinite(x); }) &&
         std::isfinite(reading.pac) && std::isfinite(reading.pdc);
}

std::size_t KeptSamples(const Tactile& tactile, const ForceNetwork* network) {
  const int window = network != nullptr ? network->info().window : 1;
  return static_cast<std::size_t>(std::clamp(window, 1, std::max(tactile.rest_samples, 1)));
}

int Samples(double seconds, double rate) {
  return static_cast<int>(std::clamp(std::round(seconds * rate), 1.0, 1e6));
}

}  // namespace

Fingertip::Fingertip(const Tactile& tactile, const ForceNetwork* network,
                     const Localiser& localiser)
    : localiser_(&localiser),
      rest_(tactile.rest_samples),
      stuck_(std::max(2, Samples(kStandsStill, tactile.rate))),
      miss_patience_(Samples(kMissing, tactile.rate)),
      release_patience_(Samples(kRelease, tactile.rate)),
      rate_(tactile.rate),
      kept_(KeptSamples(tactile, network)) {
  if (network == nullptr) return;
  network_ = network->info();
  if (!(network_.sigma.norm() > 0)) network_.sigma = kPaperSigma;
  outputs_.resize(static_cast<std::size_t>(network_.outputs));
  estimate_ = tactile.carries_state ? network->CarryingState() : network->Windowed();
  if (network_.pattern.known()) pattern_.emplace(network_.pattern, tactile.rate);
}

Fingertip::~Fingertip() = default;
Fingertip::Fingertip(Fingertip&&) noexcept = default;

void Fingertip::Reset() noexcept {
  rest_.Reset();
  stuck_.Reset();
  if (pattern_) pattern_->Reset();
  ForgetWindow();
  missed_ = quiet_ = 0;
  pressure_ = steps_ = 0;
  touch_ = {};
}

const FingerTouch& Fingertip::Estimate(const FingerReading& reading, bool after_gap,
                                       bool is_clear) noexcept {
  if (reading.present) stuck_.Take(reading);
  rest_.Advance();
  const bool repeats = reading.present && stuck_.are_repeated() && !stuck_.are_frozen();
  if (!reading.present || repeats) {
    Miss();
    return touch_;
  }
  const int missed = std::exchange(missed_, 0);
  const bool looks_back = !after_gap && missed < miss_patience_;
  if (!looks_back) ForgetWindow();
  if (!IsFinite(reading)) {
    ForgetWindow();
    Lose(FailedCheck::kElectrode, "the counts are not finite");
    return touch_;
  }
  const bool was_known = rest_.known();
  if (!was_known) {
    kept_[kept_next_] = reading;
    kept_next_ = (kept_next_ + 1) % kept_.size();
    kept_count_ = std::min(kept_count_ + 1, kept_.size());
    rest_.Take(reading);
  }
  if (!rest_.known()) {
    Lose(FailedCheck::kNone, "the baseline is being measured");
    touch_.takes_rest = true;
    return touch_;
  }
  touch_.takes_rest = false;
  if (!was_known) LearnKeptNoise();
  FollowSteps(reading, was_known && looks_back && missed == 0);
  if (was_known && is_clear) FollowRest(reading);
  FingerReading mended = reading;
  const TactileSignals change = Mend(rest_.Change(reading), &mended);
  if (was_known && looks_back) Bridge(change, missed);
  last_ = change;
  TakeForce(was_known ? Push(change) : PushKept());
  pressure_ += kBriskly * (change[kElectrodeCount + 1] - pressure_);
  if (pattern_) {
    touch_.stirs = PressureFluctuates();
    // What the pressure does not show may as well be nothing.
    const bool shows = touch_.stirs.value_or(false);
    if (touch_.force_F && !shows) {
      Widen(touch_.force_F->norm() / 2);
    }
    touch_.drift = pattern_->drift();
  }
  const TouchPlace place = localiser_->Locate(change, mended);
  DecideTouch(place);
  NoteFlaws(place);
  CheckEstimate();
  return touch_;
}

// Between what noise may be and what its absence may be nobody knows.
std::optional<bool> Fingertip::PressureFluctuates() const noexcept {
  const double noise = std::max(1.0, pattern_->noise());
  const double rest = kRestSigmas * std::sqrt(rest_.pressure_variance());
  if (pressure_ > kStirs * noise + rest) return true;
  if (pressure_ < kStirs * (2 - noise) - rest) return false;
  return std::nullopt;
}

// A contact moves electrodes and pressure; what only one of them does, or neither, is drift.
void Fingertip::FollowRest(const FingerReading& reading) noexcept {
  const TactileSignals change = rest_.Change(reading);
  double electrodes = 0;
  for (std::size_t i = 0; i < change.size(); ++i) {
    rest_average_[i] += kLevelling * (change[i] - rest_average_[i]);
    if (i < kElectrodeCount) {  // one that does not work must not speak for all
      electrodes += std::min(rest_average_[i] * rest_average_[i], kStillElectrode * kFew);
    }
  }
  const double pressure = rest_average_[kElectrodeCount + 1];
  const bool moves = electrodes > kElectrodeCount * kStillElectrode * kStillElectrode;
  if (moves && pressure > kStillPressure) return;
  const bool drifts = moves || std::abs(pressure) > kStillPressure;
  const double keep = std::exp(-1 / ((drifts ? kDrifting : kFollowing) * rate_));
  rest_.Take(reading, keep);
  for (double& average : rest_average_) average *= keep;
}

// A contact moves each electrode its own way. What moves all of them alike, from one sample to the
// next, is the electronics.
void Fingertip::FollowSteps(const FingerReading& reading, bool looks_back) noexcept {
  const auto last = std::exchange(before_, reading.electrodes);
  if (!pattern_ || !looks_back) return;
  std::array<double, kElectrodeCount> moved{};
  for (std::size_t i = 0; i < moved.size(); ++i) {
    moved[i] = static_cast<double>(reading.electrodes[i] - last[i]);
  }
  const double step = MedianOf(moved);
  const double scatter = SigmaAboutMedian(moved);
  const bool steps = std::abs(step) > std::max(kStep, kAlike * scatter);
  if (steps) rest_.Shift(step);
  steps_ = kStepsLast * steps_ + (steps ? 1 : 0);
}

// Signals as they should be used; `reading` has replaced electrodes as they should have read.
TactileSignals Fingertip::Mend(const TactileSignals& change, FingerReading* reading) noexcept {
  if (!pattern_) return change;
  Stopwatch lap;
  pattern_->Take(change, stuck_.which(), stuck_.still(), rest_.variance(), rest_.astray());
  checks_us_ = lap.Lap();
  const TactileSignals& mended = pattern_->mended();
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    if (!pattern_->is_replaced(i)) continue;
    reading->electrodes[i] += static_cast<float>(mended[i] - change[i]);
  }
  return mended;
}

void Fingertip::Miss() noexcept {
  if (missed_ < miss_patience_) ++missed_;
  if (missed_ >= miss_patience_) {
    Lose(FailedCheck::kFingerMissing, "no samples from the fingertip");
  } else if (touch_.force_F && missed_ <= kBelieved) {
    Widen(missed_ * std::max(pace_F_.norm(), step_));
  } else if (touch_.force_F) {
    touch_.Add({Validity::kStale, FailedCheck::kFingerMissing, "samples are missing"});
  }
}

// What `missed` samples would have told, linear between those before and behind.
void Fingertip::Bridge(const TactileSignals& change, int missed) noexcept {
  for (int k = 1; k <= missed; ++k) {
    const double share = static_cast<double>(k) / (missed + 1);
    TactileSignals between;
    for (std::size_t i = 0; i < between.size(); ++i) {
      between[i] = last_[i] + share * (change[i] - last_[i]);
    }
    Push(between);
  }
}

void Fingertip::Lose(FailedCheck check, std::string_view why) noexcept {
  touch_ = {};
  touch_.check = check;
  touch_.reason = why;
  quiet_ = 0;
}

void Fingertip::ForgetWindow() noexcept {
  if (estimate_) estimate_->Reset();
  steady_.Reset();
  pace_F_.setZero();
  kept_count_ = kept_next_ = 0;
  flawed_left_ = 0;
}

bool Fingertip::Push(const TactileSignals& change) noexcept {
  return estimate_ && estimate_->Push(change, outputs_);
}

// All but the newest, whose turn comes.
void Fingertip::LearnKeptNoise() noexcept {
  if (!pattern_) return;
  const std::size_t oldest = kept_.size() + kept_next_ - kept_count_;
  for (std::size_t k = 0; k + 1 < kept_count_; ++k) {
    const FingerReading& reading = kept_[(oldest + k) % kept_.size()];
    pattern_->Take(rest_.Change(reading, static_cast<double>(kept_count_ - 1 - k)), {}, {}, 0);
  }
}

bool Fingertip::PushKept() noexcept {
  bool known = false;
  for (std::size_t i = kept_.size() + kept_next_ - kept_count_; kept_count_ > 0; ++i) {
    known = Push(rest_.Change(kept_[i % kept_.size()], static_cast<double>(kept_count_ - 1)));
    --kept_count_;
  }
  return known;
}

void Fingertip::TakeForce(bool known) noexcept {
  const std::optional<Eigen::Vector3d> before_F = std::exchange(touch_.force_F, std::nullopt);
  touch_.sigma = 0;
  if (!known) return;
  Eigen::Vector3d force_F(outputs_[0], outputs_[1], outputs_[2]);
  if (!force_F.allFinite()) return;
  const double size = Eigen::Map<const Eigen::VectorXd>(last_.data(), kElectrodeCount).norm();
  if (pattern_) {
    force_F = steady_.Take(force_F, size, pattern_->noise());
  }
  step_ = before_F ? (force_F - *before_F).norm() : 0;
  leap_ = before_F ? (force_F - *before_F - pace_F_).norm() : 0;
  if (before_F) pace_F_ += kBriskly * (force_F - *before_F - pace_F_);
  touch_.force_F = force_F;
  touch_.sigma = SigmaOf(force_F);
  if (!pattern_) return;
  const double gain_sigma = pattern_->gain_sigma() * force_F.norm();
  // Signals that hardly go together any more are none that the network's error was measured on.
  const double misfit = std::max({pattern_->misfit(), pattern_->misfit_now() - kUsualScatter,
                                  pattern_->disagreement() / kHardlyAgrees});
  touch_.sigma *= std::max(1.0, misfit);
  Widen(std::hypot(pattern_->force_sigma(), gain_sigma, steady_.left_out()));
}

// By what is wrong independently of the rest [N].
void Fingertip::Widen(double by) noexcept {
  touch_.sigma = std::hypot(touch_.sigma, by);
}

// Beyond what was learnt it grows with the force, and it grows with how fast that changes. Where it
// is not known how it does before, it is that along the force; components whose error is not known
// are taken for as wrong as the worst that is.
double Fingertip::SigmaOf(const Eigen::Vector3d& force_F) const noexcept {
  const double size = force_F.norm(), largest = network_.sigma.maxCoeff();
  if (network_.error.known()) {
    const double lag = IsRecurrent(network_.architecture) ? kLag : kPromptLag;
    const ForceErrorLaw of_kind =
        pattern_ ? network_.pattern.kinds[pattern_->kind()].error : ForceErrorLaw{};
    const double learnt = (of_kind.known() ? of_kind : network_.error).At(size);
    // It was learnt of forces that change, too: only what more of that there is now counts.
    const double changing = std::hypot(lag * pace_F_.norm(), kLeap * leap_);
    return std::hypot(network_.rest_sigma, std::max(learnt, changing));
  }
  const Eigen::Vector3d sigma_F = (network_.sigma.array() > 0).select(network_.sigma, largest);
  const double sigma = size > 0 ? force_F.cwiseProduct(sigma_F).norm() / size : largest;
  return network_.learnt_force > 0 ? sigma * std::max(1.0, size / network_.learnt_force) : sigma;
}

void Fingertip::DecideTouch(const TouchPlace& place) noexcept {
  const double share = touch_.touching ? kEndShare : kBeginShare;
  const bool is_felt =
      place.usable() && (!touch_.force_F || touch_.force_F->norm() > share * network_.sigma.norm());
  if (is_felt) {
    quiet_ = 0;
    touch_.touching = true;
  } else if (touch_.touching && ++quiet_ >= release_patience_) {
    touch_.touching = false;
  }
  if (place.usable() || !touch_.touching) touch_.place = place;
}

void Fingertip::NoteFlaws(const TouchPlace& place) noexcept {
  const bool is_unmended = stuck_.count() > 0 && !pattern_;
  if (place.status == TouchPlace::Status::kFlawed || is_unmended) {
    flawed_left_ = network_.window;
  } else if (flawed_left_ > 0) {
    --flawed_left_;
  }
}

void Fingertip::CheckEstimate() noexcept {
  if (!estimate_) {
    return touch_.Set({Validity::kFailed, FailedCheck::kNone, "no network: the force is unknown"});
  }
  if (!touch_.force_F) {
    return touch_.Set(
        {Validity::kTrackingLost, FailedCheck::kNone, "the network's window is not full yet"});
  }
  touch_.Set({Validity::kValid});
  const double size = touch_.force_F->norm();
  const bool unplaced = !touch_.touching && !touch_.place.usable();
  if (network_.learnt_force > 0 && size > network_.learnt_force) {
    touch_.Fail(FailedCheck::kModelRange, "the force is beyond the training range of the network");
  }
  if (touch_.place.is_flawed) {
    touch_.Fail(FailedCheck::kElectrode, "electrodes are saturated or dead");
  }
  if (stuck_.are_frozen() || stuck_.count() == kElectrodeCount) {
    touch_.Fail(FailedCheck::kFrozen,
                "all electrodes are constant: the sensor is dead or its driver repeats samples");
  }
  if (stuck_.count() > 0 && !pattern_) {
    touch_.Fail(FailedCheck::kElectrode, "an electrode is constant: it is dead");
  }
  if (pressure_ < kBelowRest) {
    touch_.Fail(FailedCheck::kRestDrift,
                "the pressure is below its baseline: something touched the fingertip while the "
                "baseline was "
                "measured");
  }
  if (pattern_) FlagPattern();
  if (flawed_left_ > 0) {
    touch_.Fail(FailedCheck::kElectrode, "a faulty sample in the window");
  }
  if (unplaced && size > kUnseenTouch * network_.sigma.norm()) {
    touch_.Fail(FailedCheck::kTransfer, "there is a force, but no contact point");
  }
}

void Fingertip::FlagPattern() noexcept {
  if (pattern_->disagreement() > kDisagrees) {
    touch_.Fail(FailedCheck::kTransfer, "the pressure does not match the electrodes");
  }
  if (steps_ > kManySteps) {
    touch_.Fail(FailedCheck::kElectrode, "all electrodes step together repeatedly");
  }
  if (pattern_->misfit() > kMisfit) {
    touch_.Fail(FailedCheck::kElectrode, "the electrodes do not match each other");
  }
  if (pattern_->noise_since_start() < kFallen) {
    touch_.Fail(FailedCheck::kTransfer,
                "the noise of the electrodes is lower than at the start: their gain has fallen");
  }
  if (pattern_->noise() < kQuietest) {
    touch_.Fail(
        FailedCheck::kTransfer,
        "the noise of the electrodes is lower than in the training data: their gain is lower");
  }
}

}  // namespace palpate
