// The speed-accuracy trade of a scene, measured on the scene itself.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/study/candidate.h"
#include "slave/study/measurement.h"
#include "slave/study/press_spec.h"
#include "slave/study/reference.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// Marks the rows of smallest error for their update time (median), among those that answered with a
// known error and are within their range; of equal rows all are on the front.
void MarkFront(std::vector<StudyRow>* rows);

// Marks what meets the tolerance (its error, and the bound of it) and the rate [Hz] (its slowest
// percent), and recommends among the rows that are in their range at every contact; without any, at
// nine of ten; without any, all. Of those that meet both and are at most twice as slow as the
// fastest of them, the one with the least precompute. None: the one that misses tolerance or rate
// by the smallest factor. Returns why, one sentence; where none meets both, which cannot be met and
// the nearest that can; where none is in its range everywhere, at how many contacts this one is.
std::string Recommend(double tolerance, double rate, std::vector<StudyRow>* rows);

struct StudySettings {
  double budget_s = 120;  // of all candidates together [s]
  // The budget is of expected seconds, which do not depend on the machine and its load: the same
  // candidates run everywhere.
  bool counted = false;
  double timing_s = 0.15;                         // of repeated updates, per candidate [s]
  std::size_t max_memory = std::size_t{3} << 30;  // memory limit of one precompute [bytes]
  CandidateLimits limits = {};
  std::vector<Eigen::Vector3d> places = {};  // instead of the scene's own contact, see AskedOf
  bool compares = true;                      // false: times alone, without errors
};

struct StudyResult {
  std::string scene_name;
  PressSpec question;
  double tolerance = 0, rate = 0, budget_s = 0;
  std::vector<StudyRow> rows;  // by number; while it runs in the order tried
  References references;
  std::string recommendation;  // one sentence
  bool complete = false;       // every candidate was tried
};

// StudyWatcher holds callbacks for a running study; both may be empty.
struct StudyWatcher {
  std::function<void(const StudyResult&)> on_row;  // judged as far as it is, after every row
  Progress* progress = nullptr;
};

// Cheapest candidates first (linear ones, which provide the reference, count a quarter). Expected
// costs are corrected by measured ones. Candidates that exceed the rest of the budget are listed as
// skipped with their expected cost. A stop ends it the same way. Throws std::invalid_argument: see
// AskedOf.
StudyResult RunStudy(const Scene& scene, const StudySettings& settings, const ModelFactory& factory,
                     const std::stop_token& stop = {}, const StudyWatcher& watcher = {});

}  // namespace palpate::study
