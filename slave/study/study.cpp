#include "slave/study/study.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "shared/text/text.h"
#include "slave/mechanics/factory/tool_domain.h"
#include "slave/scene/model_kinds.h"
#include "slave/study/seen_press.h"

namespace palpate::study {
namespace {

constexpr double kAsFast = 2;

bool IsComparable(const StudyRow& row) {
  return row.selectable && row.outcome == Outcome::kAnswered && std::isfinite(row.error.value) &&
         std::isfinite(row.update_median_s);
}

bool Beats(const StudyRow& a, const StudyRow& b) {
  return a.error.value <= b.error.value && a.update_median_s <= b.update_median_s &&
         (a.error.value < b.error.value || a.update_median_s < b.update_median_s);
}

// Returns the error that decides whether the tolerance is kept.
double ErrorOrBound(const StudyRow& row) {
  return std::fmax(row.error.value, row.bound);
}

template <typename Allowed, typename Cost>
StudyRow* Least(std::vector<StudyRow>* rows, const Allowed& allowed, const Cost& cost) {
  StudyRow* best = nullptr;
  for (StudyRow& row : *rows) {
    if (!IsComparable(row) || !allowed(row)) continue;
    if (!best || cost(row) < cost(*best)) best = &row;
  }
  return best;
}

std::string Sentence(const StudyRow& row, const std::string& because) {
  return row.name() + ": " + because +
         Formatted(" (%.2g %% error, %.3g us per update, %.2g s of precompute)",
                   100 * row.error.value, 1e6 * row.update_p99_s, row.precompute_s);
}

// Returns which requirement the recommended row misses, if none meets both.
std::string Missed(const StudyRow& row, double tolerance, double rate) {
  std::string words = "no model meets tolerance and rate; this one is nearest to both:";
  if (!row.meets_tolerance) {
    words += Formatted(" an error of up to %.2g %% for %.3g %%", 100 * ErrorOrBound(row),
                       100 * tolerance);
  }
  if (!row.meets_rate) {
    words += Formatted("%s %.3g Hz for %.3g Hz", row.meets_tolerance ? "" : " and",
                       1 / row.update_p99_s, rate);
  }
  return words;
}

// Returns why no row meets both: which requirement cannot be met at all, or how they conflict.
template <typename Eligible>
std::string Conflict(double tolerance, double rate, const Eligible& any,
                     std::vector<StudyRow>* rows) {
  const auto error = [](const StudyRow& row) { return ErrorOrBound(row); };
  const auto slowest = [](const StudyRow& row) { return row.update_p99_s; };
  const StudyRow* exact = Least(rows, any, error);
  const StudyRow* fast = Least(rows, any, slowest);
  if (exact == nullptr) return {};
  std::string words;
  if (!exact->meets_tolerance) {
    words += Formatted("; none is within %.3g %%, the nearest is ", 100 * tolerance) +
             exact->name() +
             Formatted(" with up to %.2g %% at %.3g Hz", 100 * ErrorOrBound(*exact),
                       1 / exact->update_p99_s);
  }
  if (!fast->meets_rate) {
    words += Formatted("; none reaches %.3g Hz, the nearest is ", rate) + fast->name() +
             Formatted(" at %.3g Hz with up to %.2g %%", 1 / fast->update_p99_s,
                       100 * ErrorOrBound(*fast));
  }
  if (!words.empty()) return words;
  const StudyRow* within = Least(
      rows, [&](const StudyRow& row) { return any(row) && row.meets_tolerance; }, slowest);
  const StudyRow* in_time = Least(
      rows, [&](const StudyRow& row) { return any(row) && row.meets_rate; }, error);
  return Formatted("; within %.3g %% the fastest is ", 100 * tolerance) + within->name() +
         Formatted(" at %.3g Hz, at %.3g Hz the most accurate is ", 1 / within->update_p99_s,
                   rate) +
         in_time->name() + Formatted(" with up to %.2g %%", 100 * ErrorOrBound(*in_time));
}

// Returns a rank for the model's range at the study's contacts: 0: within at all, 1: at nine of
// ten, 2: at fewer.
std::size_t RangeOf(const StudyRow& row) {
  return row.beyond == 0 ? 0 : row.beyond <= row.answers.size() / 10 ? 1 : 2;
}

constexpr double kWorthABar = 2;  // [s]
constexpr double kNever = std::numeric_limits<double>::infinity();

// Stops a precomputation that exceeds the budget, and stores the reason.
class Allowance final : public Progress {
 public:
  Allowance(const StudySettings& settings, const ModelFactory& factory, double deadline,
            const std::stop_token& stop, std::string name, Progress* outer)
      : settings_(settings),
        factory_(factory),
        deadline_(deadline),
        stop_(stop),
        name_(std::move(name)),
        outer_(outer) {}

  void Expect(const PrecomputeCost& cost) override {
    if (cost.memory_bytes > settings_.max_memory) {
      refusal_ =
          Formatted("needs %.2g GB of memory", 1e-9 * static_cast<double>(cost.memory_bytes));
    } else if (factory_.now() + cost.seconds > deadline_) {
      refusal_ = Formatted("would take %.2g s, more than the rest of the budget", cost.seconds);
    }
  }
  bool Report(std::string_view stage, double done) override {
    if (stop_.stop_requested()) refusal_ = "interrupted";
    if (factory_.now() > deadline_) refusal_ = "stopped at the end of the budget";
    if (outer_) outer_->Report(name_ + ", " + std::string(stage), done);
    return refusal_.empty();
  }
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

 private:
  const StudySettings& settings_;
  const ModelFactory& factory_;
  double deadline_;
  const std::stop_token& stop_;
  std::string name_;
  Progress* outer_;
  std::string refusal_;
};

class Study {
 public:
  Study(const Scene& scene, const StudySettings& settings, const ModelFactory& factory,
        const std::stop_token& stop, const StudyWatcher& watcher)
      : settings_(settings), factory_(factory), stop_(stop), watcher_(watcher), scene_(scene) {
    result_.scene_name = scene.name;
    result_.question = AskedOf(scene, settings.places);
    result_.question.seen = SeePresses(scene, result_.question);
    if (!result_.question.seen.empty()) result_.question.small_depth = result_.question.depth;
    if (scene_.tool && scene_.tool->depth && IsPlanar(scene_.object.geometry)) {
      outline_ = MeshOutline(scene_, std::nullopt);
    }
    result_.tolerance = scene.model.tolerance;
    result_.rate = scene.model.rate;
    result_.budget_s = settings.budget_s;
  }

  StudyResult Run() {
    waiting_ = CandidatesFor(scene_, result_.question, settings_.limits);
    if (settings_.compares) finder_.emplace(scene_, result_.question);
    // The time for the candidates, not for the reference.
    deadline_ = factory_.now() + settings_.budget_s;
    while (!waiting_.empty()) {
      const auto next = std::ranges::min_element(
          waiting_, {}, [&](const Candidate& c) { return Urgency(c) * ExpectedSeconds(c); });
      const double expected = ExpectedSeconds(*next);
      if (stop_.stop_requested() || !(next->own_model || Affords(expected))) break;
      const Candidate candidate = std::move(*next);
      waiting_.erase(next);
      TryOne(candidate, expected);
      EvaluateErrors();
      if (watcher_.on_row) watcher_.on_row(result_);
    }
    result_.complete = waiting_.empty();
    const char* why = stop_.stop_requested() ? "interrupted" : "no time left in the budget";
    for (const Candidate& c : waiting_) {
      result_.rows.push_back(Skipped(c, why));
      result_.rows.back().expected_s = ExpectedSeconds(c);
    }
    // Sorts by number, because limits under refinement must not depend on which candidate was
    // faster.
    std::ranges::sort(result_.rows, {}, &StudyRow::number);
    EvaluateErrors();
    if (watcher_.on_row) watcher_.on_row(result_);
    return std::move(result_);
  }

 private:
  // The scene's own model is first, and runs whatever it costs. Linear models follow, because the
  // reference depends on them.
  [[nodiscard]] static double Urgency(const Candidate& c) {
    return c.own_model ? 0 : c.linear ? 0.25 : 1;
  }
  [[nodiscard]] bool Affords(double expected) const {
    return factory_.now() + expected <= deadline_;
  }
  [[nodiscard]] double ExpectedSeconds(const Candidate& c) const {
    const auto found = slower_by_.find(c.family);
    return c.expected_s * (found == slower_by_.end() ? 1 : found->second);
  }

  // `extruded`, whose places take a second each, is asked at the first contact alone.
  [[nodiscard]] PressSpec QuestionTo(const Candidate& candidate) const {
    PressSpec question = result_.question;
    if (IsSolidOutline(candidate.scene.model.kind)) question.presses.resize(1);
    return question;
  }

  void TryOne(const Candidate& candidate, double expected) {
    ReportShare();
    // A short computation needs no separate progress bar.
    Progress* const shown = expected > kWorthABar ? watcher_.progress : nullptr;
    Allowance allowance(settings_, factory_, candidate.own_model ? kNever : deadline_, stop_,
                        candidate.name(), shown);
    const double began = factory_.now();
    StudyRow row =
        Measure(candidate, QuestionTo(candidate), factory_, &allowance, settings_.timing_s);
    row.expected_s = expected;
    if (row.outcome == Outcome::kSkipped) row.reason = allowance.refusal();
    if (row.outcome == Outcome::kAnswered && candidate.expected_s > 0) {
      const double spent = std::max(factory_.now() - began - settings_.timing_s, 1e-3);
      slower_by_[candidate.family] = spent / candidate.expected_s;
    }
    result_.rows.push_back(std::move(row));
  }

  // Reports the fraction of the models or of the time, whichever is larger.
  void ReportShare() {
    if (!watcher_.progress) return;
    const auto tried = static_cast<double>(result_.rows.size());
    const double models = tried / (tried + 1 + static_cast<double>(waiting_.size()));
    const double time = 1 - (deadline_ - factory_.now()) / settings_.budget_s;
    watcher_.progress->Report("models", std::clamp(std::max(models, time), 0.0, 1.0));
  }

  void EvaluateErrors() {
    if (finder_) {
      result_.references = finder_->Find(result_.rows);
      EvaluateRows(result_.references, &result_.rows);
    }
    AddPlaneErrors();
    if (!finder_) return;
    MarkFront(&result_.rows);
    result_.recommendation = Recommend(result_.tolerance, result_.rate, &result_.rows);
  }

  // Adds the error of a plane model against a body with a thickness. `extruded` has the error of
  // its mesh alone.
  void AddPlaneErrors() {
    if (outline_.elements.empty()) return;
    for (StudyRow& row : result_.rows) {
      if (row.outcome != Outcome::kAnswered) continue;
      Scene scene = scene_;
      scene.model = row.model;
      row.plane_error = PlaneError(scene, *scene_.tool, outline_);
      if (IsSolidOutline(row.kind)) {
        row.error = {row.plane_error, 0};
        row.bound = row.plane_error;
      } else {
        row.error.value += row.plane_error;
        row.bound += row.plane_error;
      }
    }
  }

  const StudySettings& settings_;
  const ModelFactory& factory_;
  const std::stop_token& stop_;
  const StudyWatcher& watcher_;
  BoundaryMesh outline_;  // of a planar object under a tool of known extent; else empty
  double deadline_ = 0;
  Scene scene_;
  StudyResult result_;
  std::optional<ReferenceFinder> finder_;  // empty: errors are not evaluated
  std::vector<Candidate> waiting_;
  // Ratio of measured to expected time for each family's last row.
  std::map<std::string, double> slower_by_;
};

}  // namespace

Promise OnTolerance(double error, double bound, double tolerance) noexcept {
  if (!(error <= tolerance)) return Promise::kMisses;
  return bound > tolerance ? Promise::kMayMiss : Promise::kMeets;
}

Promise OnRate(double update, double rate) noexcept {
  return update * rate <= 1 ? Promise::kMeets : Promise::kMisses;
}

const char* ToString(Promise promise) {
  switch (promise) {
    case Promise::kMeets:
      return "meets";
    case Promise::kMayMiss:
      return "may miss";
    case Promise::kMisses:
      break;
  }
  return "MISSES";
}

void MarkFront(std::vector<StudyRow>* rows) {
  for (StudyRow& row : *rows) {
    row.on_front = IsComparable(row) && std::ranges::none_of(*rows, [&](const StudyRow& other) {
                     return IsComparable(other) && Beats(other, row);
                   });
  }
}

std::string Recommend(double tolerance, double rate, std::vector<StudyRow>* rows) {
  std::size_t best = 2;
  for (StudyRow& row : *rows) {
    const bool answered = row.selectable && row.outcome == Outcome::kAnswered;
    row.meets_tolerance = answered && RangeOf(row) < 2 &&
                          OnTolerance(row.error.value, row.bound, tolerance) == Promise::kMeets;
    row.meets_rate = answered && OnRate(row.update_p99_s, rate) == Promise::kMeets;
    row.recommended = false;
    if (IsComparable(row)) best = std::min(best, RangeOf(row));
  }
  const auto eligible = [&](const StudyRow& row) { return RangeOf(row) == best; };
  const auto meets_both = [&](const StudyRow& row) {
    return eligible(row) && row.meets_tolerance && row.meets_rate;
  };
  const auto update = [](const StudyRow& row) { return row.update_median_s; };
  // Expected times decide, so that the load of the machine does not change the choice.
  const auto precompute = [](const StudyRow& row) {
    return row.expected_s > 0 ? row.expected_s : row.precompute_s;
  };
  const auto missed = [&](const StudyRow& row) {
    return std::max(ErrorOrBound(row) / tolerance, row.update_p99_s * rate);
  };
  StudyRow* choice = Least(rows, meets_both, update);
  const bool meets = choice != nullptr;
  if (meets) {
    const double slowest = kAsFast * choice->update_median_s;
    const auto as_fast = [&](const StudyRow& row) {
      return meets_both(row) && row.update_median_s <= slowest;
    };
    choice = Least(rows, as_fast, precompute);
  } else {
    choice = Least(rows, eligible, missed);
  }
  if (!choice) return "no model has a known error";
  choice->recommended = true;
  std::string words = meets ? Sentence(*choice, "the cheapest that meets tolerance and rate")
                            : Sentence(*choice, Missed(*choice, tolerance, rate)) +
                                  Conflict(tolerance, rate, eligible, rows);
  if (best == 0) return words;
  const auto count = choice->answers.size();
  words += "; no model is in its range at all contacts, this one is at " +
           std::to_string(count - choice->beyond) + " of " + std::to_string(count);
  return words + (choice->reason.empty() ? "" : ": " + choice->reason);
}

StudyResult RunStudy(const Scene& scene, const StudySettings& settings, const ModelFactory& factory,
                     const std::stop_token& stop, const StudyWatcher& watcher) {
  return Study(scene, settings, factory, stop, watcher).Run();
}

}  // namespace palpate::study
