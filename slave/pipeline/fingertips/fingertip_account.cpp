// What a run over fingertips comes to: a row per sample and fingertip, and where forces were off.
#include <cmath>
#include <limits>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "slave/pipeline/fingertips/fingertip_sense.h"
#include "slave/pipeline/offline/account.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

Vector3d OrUnknown(bool known, const Vector3d& p) {
  return known ? p : Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

// Where nobody says where a fingertip is its places are empty and its force is in frame F.
StateRow RowOf(const FingerEstimate& finger, const std::string& name, const ContactEstimate& felt,
               Time start) {
  return {SecondsBetween(start, felt.sensed_at),
          felt.sample,
          name,
          OrUnknown(finger.has_pose, finger.p_S_apex),
          finger.p_S_contact.value_or(OrUnknown(false, {})),
          finger.force,
          finger.sigma,
          finger.validity,
          std::nullopt};
}

class FingertipAccount final : public Account {
 public:
  explicit FingertipAccount(const FingertipSense& sense) : sense_(sense) {}

  std::vector<StateRow> Add(Time start, const Truth* truth) override {
    const TactileEstimator& estimator = sense_.estimator();
    std::vector<StateRow> rows;
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const std::string& name = sense_.scene().sense.Find<Tactile>()->fingers[k].name;
      rows.push_back(RowOf(estimator.finger(i), name, estimator.felt(), start));
      if (truth != nullptr) rows.back().true_force = truth->fingers[k].force;
    }
    if (truth != nullptr) Compare(*truth);
    return rows;
  }

  void RequireComplete(std::uint64_t samples) const override {
    const int rest = sense_.scene().sense.Find<Tactile>()->rest_samples;
    if (samples >= static_cast<std::uint64_t>(rest)) return;
    throw std::runtime_error(
        fmt::format("{}: {} samples are fewer than the {} of `rest`: nothing can be said",
                    sense_.info().source, samples, rest));
  }

  void Finish(OfflineSummary* summary) const override {
    const TactileEstimator& estimator = sense_.estimator();
    summary->own["fingers"] = estimator.finger_count();
    summary->own["network"] =
        estimator.network() != nullptr ? estimator.network()->info().architecture : "";
    summary->own["localiser"] = estimator.localiser().name();
  }

 private:
  // What the model has at the true depth is what the master would render of the first fingertip.
  void Compare(const Truth& truth) {
    const TactileEstimator& estimator = sense_.estimator();
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const FingerTruth& finger = truth.fingers[static_cast<std::size_t>(i)];
      compared_.push_back({estimator.finger(i).force.value_or(kUnknownForce), finger.force});
      if (i > 0) continue;
      compared_.back().model_at_truth = ForceAt(estimator.felt().local_model, finger.depth);
    }
  }

  const FingertipSense& sense_;
};

}  // namespace

std::unique_ptr<Account> FingertipSense::OpenAccount(const World* /*world*/) {
  return std::make_unique<FingertipAccount>(*this);
}

}  // namespace palpate
