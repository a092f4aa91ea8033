// What a run amounts to, gathered tick by tick.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "master/haptics/record/tick_record.h"

namespace palpate {

// Error of the rendered force over the ticks of contact, when what counts as contact (1 % of the
// peak) is known only at the end. Fixed memory for runs of any length: sums per magnitude, in bins
// 1 % wide, so the border of "contact" is sharp to 1 % of itself.
class ForceError {
 public:
  struct Summary {
    double rms = 0, peak = 0;  // of |local - truth| [N]
    std::uint64_t ticks = 0;
  };
  // One tick: forces in S [N], finite.
  void Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth) noexcept;
  // Over the ticks in which either force exceeds `threshold` [N].
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

// Sorts ticks into those of a contact, and those that show the force of a membrane which is broken
// already: from the break, which no picture has shown yet, until it is told and its force has
// faded.
class BreakingError {
 public:
  // One tick, in order: forces in S [N], finite; `punctured`: it has been told. The tick goes to
  // `contact`, at once or when no puncture was told soon after it, or stays here.
  void Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth, bool punctured,
           ForceError* contact);
  // What waits goes to `contact`.
  void Close(ForceError* contact);
  [[nodiscard]] const ForceError& error() const noexcept { return error_; }
  [[nodiscard]] std::uint64_t punctures() const noexcept { return punctures_; }
  // Of the punctures, the most ticks from the break to no force.
  [[nodiscard]] std::uint64_t longest() const noexcept { return longest_; }

 private:
  ForceError error_;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> waiting_;  // local, truth
  bool punctured_ = false;
  std::uint64_t punctures_ = 0, longest_ = 0, breaking_ = 0;
};

// What a run amounts to for one fingertip.
struct FingerSummary {
  std::uint64_t ticks = 0, contact_ticks = 0;  // with a state at all; of them touching
  double force_peak = 0;                       // largest known force [N]

  [[nodiscard]] double contact_share() const {
    return ticks > 0 ? static_cast<double>(contact_ticks) / static_cast<double>(ticks) : 0;
  }
};

class TickSummary {
 public:
  // `truth`: true force at the tick's instant, S [N]; nothing: unknown.
  void Add(const TickRecord& record, const std::optional<Eigen::Vector3d>& truth);
  // `truth`: true force while the slave did what was commanded at this tick, S [N]; nothing:
  // unknown.
  void AddDelayCompensated(const TickRecord& record, const std::optional<Eigen::Vector3d>& truth);
  // A true force as it came: peaks count whether or not a tick meets them.
  void AddTruth(const Eigen::Vector3d& truth) noexcept;

  [[nodiscard]] bool has_truth() const noexcept { return has_truth_; }
  // Largest true force, else largest estimated one, S [N].
  [[nodiscard]] double force_peak() const noexcept {
    return has_truth_ ? truth_peak_ : estimated_peak_;
  }
  [[nodiscard]] double sent_peak() const noexcept { return sent_peak_; }  // M [N]
  // No tick follows.
  void Close();
  // Over the ticks in which either force exceeds 1 % of the peak, those of a breaking membrane
  // apart; nothing without a true force.
  [[nodiscard]] std::optional<ForceError::Summary> force_error() const noexcept;
  // Of those ticks, the ones in which the hand was let go: it was shown nothing, whatever the tool
  // still pressed.
  [[nodiscard]] std::uint64_t let_go_ticks() const noexcept;
  // The same against the truth at the commanded place, while following: of the first contact, in
  // which much is still on its way, and of those after it.
  struct DelayCompensated {
    ForceError::Summary later, first;
  };
  [[nodiscard]] std::optional<DelayCompensated> force_error_delay_compensated() const noexcept;
  struct Breaking {
    ForceError::Summary error;
    std::uint64_t punctures = 0;
    std::uint64_t longest = 0;  // from the break to no force, ticks
  };
  // Nothing: no membrane broke.
  [[nodiscard]] std::optional<Breaking> breaking() const noexcept;
  [[nodiscard]] std::uint64_t ticks(Reason reason) const noexcept {
    return reason_ticks_[static_cast<std::size_t>(reason)];
  }
  [[nodiscard]] std::uint64_t ticks(OperatorState state) const noexcept {
    return state_ticks_[static_cast<std::size_t>(state)];
  }
  // In the scene's order, as many as were told of; one: the tool alone.
  [[nodiscard]] std::span<const FingerSummary> fingers() const noexcept {
    return {fingers_.data(), finger_count_};
  }
  // Ticks without a fresh state, of those after the first state had come.
  [[nodiscard]] std::uint64_t stale_ticks() const noexcept { return stale_ticks_; }
  [[nodiscard]] std::uint32_t epochs() const noexcept { return epochs_; }

 private:
  void AddFingers(const TickRecord& record) noexcept;

  ForceError error_, let_go_;
  BreakingError breaking_, breaking_delay_compensated_;
  ForceError delay_compensated_, first_contact_;
  enum class Contact : std::uint8_t { kNone, kFirst, kLater } contact_ = Contact::kNone;
  double delay_compensated_peak_ = 0;  // of what AddDelayCompensated was given [N]
  std::uint64_t free_ticks_ = 0;       // since the first contact was left
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
