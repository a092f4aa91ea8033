// Hooks that record each sample of a sensing, or replay recorded ones.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "slave/capture/frame_source.h"
#include "slave/capture/tactile_frame.h"

namespace palpate {

// Is called by the thread that waits for samples, and must not block it.
class SampleTap {
 public:
  virtual ~SampleTap() = default;
  // Reports that a source begins; earlier samples came from a source that could not be used.
  virtual void Opened() = 0;
  virtual void OnSample(const Frame& frame) = 0;
  virtual void OnSample(const StereoPair& pair) = 0;
  virtual void OnSample(const TactileFrame& frame) = 0;
};

// Replays recorded samples. One source at a time; the player outlives it.
class SamplePlayer {
 public:
  virtual ~SamplePlayer() = default;
  virtual std::unique_ptr<FrameSource> OpenFrames() = 0;
  virtual std::unique_ptr<StereoSource> OpenPairs() = 0;
  virtual std::unique_ptr<TactileSource> OpenFingertips() = 0;
};

// Passes each sample of `inner` to `tap` before it returns it.
template <typename Source>
class TappedSource : public Source {
 public:
  using Sample = typename decltype(std::declval<Source&>().Next({}))::value_type;

  TappedSource(std::unique_ptr<Source> inner, SampleTap* tap)
      : inner_(std::move(inner)), tap_(tap) {
    tap_->Opened();
  }
  std::optional<Sample> Next(const std::stop_token& stop) override {
    std::optional<Sample> sample = inner_->Next(stop);
    if (sample) tap_->OnSample(*sample);
    return sample;
  }
  [[nodiscard]] std::string description() const override { return inner_->description(); }
  [[nodiscard]] Source* inner() const { return inner_.get(); }

 private:
  std::unique_ptr<Source> inner_;
  SampleTap* tap_;
};

template <typename Image>
class TappedImages final : public TappedSource<ImageSource<Image>> {
 public:
  using TappedSource<ImageSource<Image>>::TappedSource;
  [[nodiscard]] std::optional<CameraHealth> health() const override {
    return this->inner()->health();
  }
};

// Returns `source` itself if there is no tap.
template <typename Image>
std::unique_ptr<ImageSource<Image>> Tapped(std::unique_ptr<ImageSource<Image>> source,
                                           SampleTap* tap) {
  if (tap == nullptr) return source;
  return std::make_unique<TappedImages<Image>>(std::move(source), tap);
}
inline std::unique_ptr<TactileSource> Tapped(std::unique_ptr<TactileSource> source,
                                             SampleTap* tap) {
  if (tap == nullptr) return source;
  return std::make_unique<TappedSource<TactileSource>>(std::move(source), tap);
}
// Returns the source behind the tap, if there is one.
template <typename Source>
Source* Untapped(Source* source) {
  auto* tapped = dynamic_cast<TappedSource<Source>*>(source);
  return tapped != nullptr ? tapped->inner() : source;
}

}  // namespace palpate
