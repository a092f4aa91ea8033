#include "slave/tactile/fingertip.h"

#include <cmath>

namespace palpate {
namespace {

// Of networks that do not say their error: paper B, table I, rnn_21 [N].
const Eigen::Vector3d kPaperSigma{0.01807, 0.03107, 0.05171};
constexpr double kBeginShare = 0.5, kEndShare = 0.25;  // of the error's size
constexpr double kUnseenTouch = 3;                     // times the error: no electrode, yet a force
constexpr double kRelease = 0.050, kMissing = 0.060;   // [s]

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
      kept_(KeptSamples(tactile, network)) {
  if (network == nullptr) return;
  network_ = network->info();
  if (!(network_.sigma.norm() > 0)) network_.sigma = kPaperSigma;
  outputs_.resize(static_cast<std::size_t>(network_.outputs));
  estimate_ = tactile.carries_state ? network->CarryingState() : network->Windowed();
}

Fingertip::~Fingertip() = default;
Fingertip::Fingertip(Fingertip&&) noexcept = default;

void Fingertip::Reset() noexcept {
  rest_.Reset();
  stuck_.Reset();
  ForgetWindow();
  missed_ = quiet_ = 0;
  touch_ = {};
}

const FingerTouch& Fingertip::Feel(const FingerReading& reading, bool after_gap) noexcept {
  if (!reading.present) {
    Miss();
    return touch_;
  }
  if (after_gap || missed_ > 0) ForgetWindow();
  missed_ = 0;
  if (!IsFinite(reading)) {
    ForgetWindow();
    Lose("the counts are not finite");
    return touch_;
  }
  stuck_.Take(reading);
  const bool was_known = rest_.known();
  if (!was_known) {
    kept_[kept_next_] = reading;
    kept_next_ = (kept_next_ + 1) % kept_.size();
    kept_count_ = std::min(kept_count_ + 1, kept_.size());
    rest_.Take(reading);
  }
  if (!rest_.known()) {
    Lose("rest values are being taken");
    return touch_;
  }
  const TactileSignals change = rest_.Change(reading);
  TakeForce(was_known ? Push(change) : PushKept());
  const TouchPlace place = localiser_->Locate(change, reading);
  DecideTouch(place);
  NoteFlaws(place);
  Judge();
  return touch_;
}

void Fingertip::Miss() noexcept {
  if (missed_ < miss_patience_) ++missed_;
  if (missed_ >= miss_patience_) {
    Lose("the fingertip is silent");
  } else if (touch_.force_F) {
    touch_.validity = Worse(touch_.validity, Validity::kStale);
    touch_.why = "samples are missing";
  }
}

void Fingertip::Lose(std::string_view why) noexcept {
  touch_ = {};
  touch_.why = why;
  quiet_ = 0;
}

void Fingertip::ForgetWindow() noexcept {
  if (estimate_) estimate_->Reset();
  kept_count_ = kept_next_ = 0;
  flawed_left_ = 0;
}

bool Fingertip::Push(const TactileSignals& change) noexcept {
  return estimate_ && estimate_->Push(change, outputs_);
}

bool Fingertip::PushKept() noexcept {
  bool known = false;
  for (std::size_t i = kept_.size() + kept_next_ - kept_count_; kept_count_ > 0; ++i) {
    known = Push(rest_.Change(kept_[i % kept_.size()]));
    --kept_count_;
  }
  return known;
}

void Fingertip::TakeForce(bool known) noexcept {
  touch_.force_F.reset();
  touch_.sigma = 0;
  if (!known) return;
  const Eigen::Vector3d force_F(outputs_[0], outputs_[1], outputs_[2]);
  if (!force_F.allFinite()) return;
  touch_.force_F = force_F;
  touch_.sigma = SigmaOf(force_F);
}

// Along the force; beyond what was learnt it grows with it. Components whose error is not known are
// taken for as wrong as the worst that is.
double Fingertip::SigmaOf(const Eigen::Vector3d& force_F) const noexcept {
  const double size = force_F.norm(), largest = network_.sigma.maxCoeff();
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
  if (place.status == TouchPlace::Status::kFlawed || stuck_.count() > 0) {
    flawed_left_ = network_.window;
  } else if (flawed_left_ > 0) {
    --flawed_left_;
  }
}

void Fingertip::Judge() noexcept {
  touch_.why = {};
  if (!estimate_) {
    touch_.validity = Validity::kFailed;
    touch_.why = "no network: the force is unknown";
    return;
  }
  if (!touch_.force_F) {
    touch_.validity = Validity::kTrackingLost;
    touch_.why = "the network's window is not full yet";
    return;
  }
  const double size = touch_.force_F->norm();
  if (network_.learnt_force > 0 && size > network_.learnt_force) {
    touch_.why = "the force is beyond what the network has learnt";
  } else if (touch_.place.is_flawed) {
    touch_.why = "electrodes are saturated or dead";
  } else if (stuck_.count() == kElectrodeCount) {
    touch_.why = "all electrodes stand still: the sensor is dead or its driver repeats itself";
  } else if (stuck_.count() > 0) {
    touch_.why = "an electrode stands still: it is dead";
  } else if (flawed_left_ > 0) {
    touch_.why = "a flawed sample in the window";
  } else if (!touch_.touching && !touch_.place.usable() &&
             size > kUnseenTouch * network_.sigma.norm()) {
    touch_.why = "there is a force, but no place of it";
  }
  touch_.validity = touch_.why.empty() ? Validity::kValid : Validity::kExtrapolated;
}

}  // namespace palpate
