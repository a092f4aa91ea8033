#include "slave/tactile/fingertip.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/program/stopwatch.h"

namespace palpate {
namespace {

// Shares of the error's size. [-] [tuned: AForceWithinTheNetworksErrorIsNoTouch]
constexpr double kBeginShare = 0.5, kEndShare = 0.25;
constexpr double kRises = 3;       // 0.02 N [counts]
constexpr double kRestSigmas = 2;  // sigmas by which the pressure's baseline may also deviate
// Largest change of a channel while the baseline is measured: more is not noise [noise at rest].
constexpr double kConstantSamples = 20;
// Largest force of a baseline: relative to that of the training's baselines, plus a number of
// sigmas [-].
constexpr double kSameRest = 2, kBaselineSigmas = 3;
// Largest number of missing samples without a flag. [-] [tuned: AFewMissingSamplesAreMadeUpFor]
constexpr int kBelieved = 2;
// Times of a release and of missing samples [s]. [tuned: APressDeeperThanAFingertipKeepsItsShape,
// ASilentFingertipIsStaleThenLostAndItsWindowStartsAgain]
constexpr double kRelease = 0.050, kMissing = 0.060;

bool IsFinite(const FingerReading& reading) {
  return std::ranges::all_of(reading.channels, [](float x) { return std::isfinite(x); }) &&
         std::isfinite(reading.pac) && std::isfinite(reading.pdc);
}

std::size_t KeptSamples(const Tactile& tactile, const ForceNetwork* network) {
  const int window = network != nullptr ? network->info().window : 1;
  return static_cast<std::size_t>(std::clamp(window, 1, std::max(tactile.rest_samples, 1)));
}

int Samples(double seconds, double rate) {
  return static_cast<int>(std::clamp(std::round(seconds * rate), 1.0, 1e6));
}

// Returns how long channels may be constant [samples]; 0: no limit.
int MaxConstantSamples(const NetworkInfo& network, double rate) {
  return network.longest_constant > 0 ? std::max(2, Samples(network.longest_constant, rate)) : 0;
}

}  // namespace

Fingertip::Fingertip(const Tactile& tactile, const ForceNetwork* network,
                     const Localiser& localiser)
    : localiser_(&localiser),
      force_(network),
      baseline_(tactile.rest_samples, tactile.rate,
                {.channels = static_cast<std::size_t>(tactile.channels.count),
                 .noise = this->network().noise,
                 .has_pressure = tactile.channels.are_electrodes()}),
      stuck_(MaxConstantSamples(this->network(), tactile.rate), tactile.channels.count,
             tactile.channels.are_electrodes()),
      channels_(static_cast<std::size_t>(tactile.channels.count)),
      max_missed_(Samples(kMissing, tactile.rate)),
      release_samples_(Samples(kRelease, tactile.rate)),
      kept_(KeptSamples(tactile, network)) {
  if (this->network().pattern.known()) model_.emplace(this->network().pattern, tactile.rate);
  if (this->network().channel_pattern) channel_signals_.emplace(this->network().channel_pattern);
}

void Fingertip::Reset() noexcept {
  baseline_.Reset();
  stuck_.Reset();
  if (model_) model_->Reset();
  if (channel_signals_) channel_signals_->Reset();
  baseline_fault_ = {};
  ForgetWindow();
  missed_ = quiet_ = 0;
  pressure_ = 0;
  touch_ = {};
}

const FingerTouch& Fingertip::Estimate(const FingerReading& reading, bool after_gap,
                                       bool is_clear) noexcept {
  if (reading.present) stuck_.Take(reading, !baseline_.known());
  baseline_.Advance();
  const bool repeats = reading.present && stuck_.are_repeated() && !stuck_.are_frozen();
  if (!reading.present || repeats) {
    Miss();
    return touch_;
  }
  const int missed = std::exchange(missed_, 0);
  const bool looks_back = !after_gap && missed < max_missed_;
  if (!looks_back) ForgetWindow();
  if (reading.channels.size() != channels_ || !IsFinite(reading)) {
    ForgetWindow();
    Lose(FailedCheck::kElectrode, "the channels are not finite, or not as many as the scene's");
    return touch_;
  }
  const bool was_known = baseline_.known();
  if (!UpdateBaseline(reading, is_clear)) return touch_;
  if (channel_signals_) {
    if (!looks_back || missed > 0) channel_signals_->Skip();
    channel_signals_->Update(baseline_.Change(reading));
  }
  FingerReading corrected = reading;
  const TactileSignals change = Correct(baseline_.Change(reading), &corrected);
  if (was_known && looks_back) force_.Bridge(change, missed);
  EstimateForce(change, was_known ? force_.Push(change) : PushKept());
  const TouchPlace place = PlaceOf(change, corrected);
  DecideTouch(place);
  NoteFlaws(place);
  touch_.Set(VerdictOfForce());
  return touch_;
}

bool Fingertip::UpdateBaseline(const FingerReading& reading, bool is_clear) noexcept {
  const bool was_known = baseline_.known();
  if (!was_known) Keep(reading);
  if (!baseline_.known()) {
    Lose(FailedCheck::kNone, "the baseline is being measured");
    touch_.is_baseline = true;
    return false;
  }
  touch_.is_baseline = false;
  if (!was_known) {
    LearnKeptNoise();
    ExamineBaseline();
  }
  if (was_known && is_clear) baseline_.Follow(reading);
  return true;
}

// Detects a contact while the baseline is measured: the channels move, or differ from those in the
// training.
void Fingertip::ExamineBaseline() noexcept {
  const NetworkInfo& network = this->network();
  if (network.channels.are_electrodes()) return;
  if (baseline_.spread() > kConstantSamples * network.noise) {
    baseline_fault_ =
        "a channel moved while the baseline was measured: something touched the sensor, or shook "
        "it";
  }
  if (!network.channel_pattern || network.channel_pattern->baseline.size() == 0) return;
  FingerReading usual;
  usual.channels.resize(channels_);
  for (std::size_t i = 0; i < channels_; ++i) {
    usual.channels[i] =
        static_cast<float>(network.channel_pattern->baseline[static_cast<Eigen::Index>(i)]);
  }
  TactileSignals change = baseline_.Change(usual);
  for (std::size_t i = 0; i < channels_; ++i) change[i] = -change[i];
  const auto force_F = force_.ForceOf(change);
  const double most =
      kSameRest * network.channel_pattern->baseline_force + kBaselineSigmas * network.rest_sigma;
  if (force_F && !(force_F->norm() <= most)) {
    baseline_fault_ =
        "the baseline is another than in the training: something touched the sensor while it was "
        "measured";
  }
}

void Fingertip::EstimateForce(const TactileSignals& change, bool is_full) noexcept {
  const auto [force_F, sigma] = force_.Take(change, is_full, touch_.force_F, signals());
  touch_.force_F = force_F;
  touch_.sigma = sigma;
  pressure_ += WindowForce::kBriskly * (change.back() - pressure_);
  if (touch_.force_F) Widen(network().drift * baseline_.age());
  if (!model_) return;
  touch_.drift = model_->drift();
  // A force that the pressure does not confirm may be zero.
  if (touch_.force_F && !PressureRises()) Widen(touch_.force_F->norm() / 2);
}

// Returns whether the pressure rises; it can be called before the force is known.
bool Fingertip::PressureRises() const noexcept {
  const double noise = std::max(1.0, model_->noise().relative());
  return pressure_ > kRises * noise + kRestSigmas * std::sqrt(baseline_.pressure_variance());
}

TouchPlace Fingertip::PlaceOf(const TactileSignals& change,
                              const FingerReading& reading) const noexcept {
  TouchPlace place = localiser_->Locate(change, reading);
  const auto p_F = force_.contact_point();
  if (!p_F || !place.usable()) return place;
  place.p_F = *p_F;
  place.n_F = FingerSurface{}.Normal(*p_F);
  return place;
}

// Returns the corrected signals. `reading` gets the expected values of replaced electrodes.
TactileSignals Fingertip::Correct(const TactileSignals& change, FingerReading* reading) noexcept {
  if (!model_) return change;
  Stopwatch lap;
  model_->Update(change, stuck_.which(), stuck_.still(), baseline_.variance(),
                 baseline_.drift_sigma());
  checks_us_ = lap.Lap();
  const TactileSignals& corrected = model_->corrected();
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    if (!model_->is_replaced(i)) continue;
    reading->channels[i] += static_cast<float>(corrected[i] - change[i]);
  }
  return corrected;
}

void Fingertip::Miss() noexcept {
  if (missed_ < max_missed_) ++missed_;
  if (missed_ >= max_missed_) {
    Lose(FailedCheck::kFingerMissing, "no samples from the fingertip");
  } else if (touch_.force_F && missed_ <= kBelieved) {
    Widen(missed_ * force_.pace());
  } else if (touch_.force_F) {
    touch_.Add({Validity::kStale, FailedCheck::kFingerMissing, "samples are missing"});
  }
}

void Fingertip::Lose(FailedCheck check, std::string_view why) noexcept {
  touch_ = {};
  touch_.check = check;
  touch_.reason = why;
  quiet_ = 0;
}

void Fingertip::ForgetWindow() noexcept {
  force_.Reset();
  kept_count_ = kept_next_ = 0;
  flawed_left_ = 0;
}

void Fingertip::Keep(const FingerReading& reading) noexcept {
  kept_[kept_next_] = reading;
  kept_next_ = (kept_next_ + 1) % kept_.size();
  kept_count_ = std::min(kept_count_ + 1, kept_.size());
  baseline_.Take(reading);
}

// Learns from all readings except the newest, which is processed later.
void Fingertip::LearnKeptNoise() noexcept {
  if (!model_) return;
  const std::size_t oldest = kept_.size() + kept_next_ - kept_count_;
  for (std::size_t k = 0; k + 1 < kept_count_; ++k) {
    const FingerReading& reading = kept_[(oldest + k) % kept_.size()];
    model_->Update(baseline_.Change(reading, static_cast<double>(kept_count_ - 1 - k)), {}, {}, 0);
  }
}

bool Fingertip::PushKept() noexcept {
  bool known = false;
  for (std::size_t i = kept_.size() + kept_next_ - kept_count_; kept_count_ > 0; ++i) {
    known = force_.Push(
        baseline_.Change(kept_[i % kept_.size()], static_cast<double>(kept_count_ - 1)));
    --kept_count_;
  }
  return known;
}

// Adds an error that is independent of the others [N].
void Fingertip::Widen(double by) noexcept {
  touch_.sigma = std::hypot(touch_.sigma, by);
}

void Fingertip::DecideTouch(const TouchPlace& place) noexcept {
  const double share = touch_.touching ? kEndShare : kBeginShare;
  const bool is_contact = place.usable() && (!touch_.force_F || touch_.force_F->norm() >
                                                                    share * network().sigma.norm());
  if (is_contact) {
    quiet_ = 0;
    touch_.touching = true;
  } else if (touch_.touching && ++quiet_ >= release_samples_) {
    touch_.touching = false;
  }
  if (place.usable() || !touch_.touching) touch_.place = place;
}

void Fingertip::NoteFlaws(const TouchPlace& place) noexcept {
  const bool is_unmended =
      (stuck_.count() > 0 && !model_) || (channel_signals_ && !channel_signals_->fault().empty());
  if (place.status == TouchPlace::Status::kFlawed || is_unmended) {
    flawed_left_ = network().window;
  } else if (flawed_left_ > 0) {
    --flawed_left_;
  }
}

Verdict Fingertip::VerdictOfForce() const noexcept {
  if (!force_.has_network()) {
    return {Validity::kFailed, FailedCheck::kNone, "no network: the force is unknown"};
  }
  if (!touch_.force_F) {
    return {Validity::kTrackingLost, FailedCheck::kNone, "the network's window is not full yet"};
  }
  return {Validity::kValid};
}

}  // namespace palpate
