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

constexpr double kContactShare = 0.01;  // of the peak: below it a sample does not count as contact

// One fingertip's forces in one sample [N].
struct Compared {
  double error, estimated, truth;
  double model_error;  // NaN: none
};

// Errors over samples in which estimate or truth exceed 1 % of the true peak [N].
struct TouchError {
  std::uint64_t count = 0;   // samples of all fingertips
  double rms = 0, peak = 0;  // of the force's vector, estimate minus truth
  double true_peak = 0;      // largest true force
  double model_rms = 0;      // size of what the master would render at the true depth, the first's
};

class Comparison {
 public:
  void Add(const TactileEstimator& estimator, const Truth& truths) {
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const FingerEstimate& felt = estimator.finger(i);
      const FingerTruth& truth = truths.fingers[static_cast<std::size_t>(i)];
      peak_ = std::fmax(peak_, truth.force.norm());
      if (!felt.force) continue;
      rows_.push_back({(*felt.force - truth.force).norm(), felt.force->norm(), truth.force.norm(),
                       i == 0 ? ModelError(estimator.felt().local_model, truth)
                              : std::numeric_limits<double>::quiet_NaN()});
    }
  }
  [[nodiscard]] TouchError Result() const {
    TouchError result;
    result.true_peak = peak_;
    double sum = 0, model_sum = 0;
    std::uint64_t model_count = 0;
    for (const Compared& row : rows_) {
      if (std::fmax(row.estimated, row.truth) <= kContactShare * peak_) continue;
      ++result.count;
      sum += row.error * row.error;
      result.peak = std::fmax(result.peak, row.error);
      if (!std::isfinite(row.model_error)) continue;
      ++model_count;
      model_sum += row.model_error * row.model_error;
    }
    result.rms = result.count > 0 ? std::sqrt(sum / static_cast<double>(result.count)) : 0;
    result.model_rms =
        model_count > 0 ? std::sqrt(model_sum / static_cast<double>(model_count)) : 0;
    return result;
  }

 private:
  static double ModelError(const LocalModel& local, const FingerTruth& truth) {
    return (local.stiffness * local.normal * truth.depth).norm() - truth.force.norm();
  }

  std::vector<Compared> rows_;
  double peak_ = 0;
};

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

nlohmann::ordered_json ErrorJson(const TouchError& error) {
  if (error.count == 0) return nullptr;
  return {{"rms_N", error.rms},
          {"peak_N", error.peak},
          {"contact_samples", error.count},
          {"true_peak_N", error.true_peak},
          {"model_rms_N", error.model_rms}};
}

class FingertipAccount final : public Account {
 public:
  explicit FingertipAccount(const FingertipSense& sense) : sense_(sense) {}

  std::vector<StateRow> Add(Time start, const Truth* truth) override {
    const TactileEstimator& estimator = sense_.estimator();
    std::vector<StateRow> rows;
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const std::string& name = sense_.scene().sense.tactile->fingers[k].name;
      rows.push_back(RowOf(estimator.finger(i), name, estimator.felt(), start));
      if (truth != nullptr) rows.back().true_force = truth->fingers[k].force;
    }
    if (truth != nullptr) comparison_.Add(estimator, *truth);
    return rows;
  }

  void RequireComplete(std::uint64_t samples) const override {
    const int rest = sense_.scene().sense.tactile->rest_samples;
    if (samples >= static_cast<std::uint64_t>(rest)) return;
    throw std::runtime_error(
        fmt::format("{}: {} samples are fewer than the {} of `rest`: nothing can be said",
                    sense_.info().source, samples, rest));
  }

  void Finish(OfflineSummary* summary) const override {
    const TactileEstimator& estimator = sense_.estimator();
    const TouchError error = comparison_.Result();
    if (summary->has_truth) summary->force_error = ErrorJson(error);
    summary->own["fingers"] = estimator.finger_count();
    summary->own["network"] =
        estimator.network() != nullptr ? estimator.network()->info().architecture : "";
    summary->own["localiser"] = estimator.localiser().name();
    if (error.count == 0) return;
    summary->lines.push_back(fmt::format(
        "force error over {} samples in contact, true peak {:.4g} N: rms {:.3g} N ({:.2f} % of the "
        "peak), largest {:.3g} N; of the contact that the master renders {:.3g} N",
        error.count, error.true_peak, error.rms, 100 * error.rms / error.true_peak, error.peak,
        error.model_rms));
  }

 private:
  const FingertipSense& sense_;
  Comparison comparison_;
};

}  // namespace

std::unique_ptr<Account> FingertipSense::OpenAccount(const World* /*world*/) {
  return std::make_unique<FingertipAccount>(*this);
}

}  // namespace palpate
