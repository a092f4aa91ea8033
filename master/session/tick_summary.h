// Summary of a run, accumulated tick by tick.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "master/haptics/tick_record.h"

namespace palpate {

// Error of the rendered force over the ticks of contact. The threshold of contact (1 % of the peak)
// is known only at the end, so sums are kept per magnitude in bins 1 % wide. The memory is fixed.
class ForceError {
 public:
  struct Summary {
    double rms = 0, peak = 0;  // of |local - truth| [N]
    std::uint64_t ticks = 0;
  };
  // Adds one tick: forces in S [N], finite.
  void Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth) noexcept;
  // Returns the summary of the ticks in which either force exceeds `threshold` [N].
  [[nodiscard]] Summary Above(double threshold) const noexcept;
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }

 private:
  struct Bin {
    double sum_of_squares = 0, peak = 0;
    std::uint64_t ticks = 0;
  };
  static constexpr int kBins = 4000;  // 1 pN to 190 kN
  std::array<Bin, kBins> bins_{};
  std::uint64_t count_ = 0;
};

// Separates ticks of contact from those that still render the force of a broken membrane: from the
// break, which no image shows yet, until the puncture is reported and the force has faded.
class BreakingError {
 public:
  // Adds one tick, in order: forces in S [N], finite; `punctured`: the puncture is reported. The
  // tick is added to `contact` unless a puncture is reported soon after it.
  void Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth, bool punctured,
           ForceError* contact);
  // Adds the waiting ticks to `contact`.
  void Close(ForceError* contact);
  [[nodiscard]] const ForceError& error() const noexcept { return error_; }
  [[nodiscard]] std::uint64_t punctures() const noexcept { return punctures_; }
  // Largest number of ticks from a break until the force is zero.
  [[nodiscard]] std::uint64_t longest() const noexcept { return max_ticks_; }

 private:
  ForceError error_;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> waiting_;  // local, truth
  bool punctured_ = false;
  std::uint64_t punctures_ = 0, max_ticks_ = 0, breaking_ = 0;
};

// Summary of one fingertip.
struct FingerSummary {
  std::uint64_t ticks = 0, contact_ticks = 0;  // ticks with a state; ticks in contact
  double force_peak = 0;                       // largest known force [N]

  [[nodiscard]] double contact_share() const {
    return ticks > 0 ? static_cast<double>(contact_ticks) / static_cast<double>(ticks) : 0;
  }
};

class TickSummary {
 public:
  // Adds a tick. `truth`: true force at the same instant, S [N]; empty: unknown.
  void Add(const TickRecord& record, const std::optional<Eigen::Vector3d>& truth);
  // Adds a tick. `truth`: true force when the slave executed the command of this tick, S [N];
  // empty: unknown.
  void AddDelayCompensated(const TickRecord& record, const std::optional<Eigen::Vector3d>& truth);
  // Adds a received true force, so that its peak counts even between ticks.
  void AddTruth(const Eigen::Vector3d& truth) noexcept;

  [[nodiscard]] bool has_truth() const noexcept { return has_truth_; }
  // Largest true force, else largest estimated one, S [N].
  [[nodiscard]] double force_peak() const noexcept {
    return has_truth_ ? truth_peak_ : estimated_peak_;
  }
  [[nodiscard]] double sent_peak() const noexcept { return sent_peak_; }  // M [N]
  // Ends the summary: no tick follows.
  void Close();
  // Returns the error over the ticks in which either force exceeds 1 % of the peak, without those
  // of a breaking membrane; empty without a true force.
  [[nodiscard]] std::optional<ForceError::Summary> force_error() const noexcept;
  // Number of those ticks in which the operator was disengaged: no force was rendered, although the
  // tool was still in contact.
  [[nodiscard]] std::uint64_t let_go_ticks() const noexcept;
  // Error against the true force at the same commanded position, while following. The first
  // contact, in which the model is still incomplete, is separate from the later ones.
  struct DelayCompensated {
    ForceError::Summary later, first;
  };
  [[nodiscard]] std::optional<DelayCompensated> force_error_delay_compensated() const noexcept;
  struct Breaking {
    ForceError::Summary error;
    std::uint64_t punctures = 0;
    std::uint64_t longest = 0;  // ticks from the break until the force is zero
  };
  // Empty without a puncture.
  [[nodiscard]] std::optional<Breaking> breaking() const noexcept;
  [[nodiscard]] std::uint64_t ticks(Reason reason) const noexcept {
    return reason_ticks_[static_cast<std::size_t>(reason)];
  }
  [[nodiscard]] std::uint64_t ticks(OperatorState state) const noexcept {
    return state_ticks_[static_cast<std::size_t>(state)];
  }
  // Returns the fingertips in the scene's order; one: the single tool.
  [[nodiscard]] std::span<const FingerSummary> fingers() const noexcept {
    return {fingers_.data(), finger_count_};
  }
  // Returns the ticks without a fresh state, counted after the first state.
  [[nodiscard]] std::uint64_t stale_ticks() const noexcept { return stale_ticks_; }
  [[nodiscard]] std::uint32_t epochs() const noexcept { return epochs_; }

 private:
  void AddFingers(const TickRecord& record) noexcept;

  ForceError error_, let_go_;
  BreakingError breaking_, breaking_delay_compensated_;
  ForceError delay_compensated_, first_contact_;
  enum class Contact : std::uint8_t { kNone, kFirst, kLater } contact_ = Contact::kNone;
  double delay_compensated_peak_ = 0;  // largest force of AddDelayCompensated [N]
  std::uint64_t free_ticks_ = 0;       // since the end of the first contact
  bool has_truth_ = false;
  double truth_peak_ = 0, estimated_peak_ = 0, sent_peak_ = 0;
  std::array<std::uint64_t, kReasonCount> reason_ticks_{};
  std::array<std::uint64_t, kOperatorStateCount> state_ticks_{};
  std::array<FingerSummary, kMaxFingers> fingers_{};
  std::size_t finger_count_ = 0;
  std::uint64_t stale_ticks_ = 0;
  std::uint32_t epochs_ = 0;
};

}  // namespace palpate
