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

// Marks the rows on the Pareto front of error and median update time, among those with a known
// error that are within their range; equal rows are all on the front.
void MarkFront(std::vector<StudyRow>* rows);

// Marks the rows that meet the tolerance (error and its bound) and the rate [Hz] (slowest percent),
// and recommends one. It considers the rows that are within their range at every contact; if there
// are none, at nine of ten contacts; if there are none, all rows. Among the rows that meet both and
// are at most twice as slow as the fastest of them, it recommends the one with the shortest
// precomputation. If none meets both, it recommends the one that misses tolerance or rate by the
// smallest factor. Returns the reason as one sentence: also which requirement cannot be met and the
// nearest one that can, and at how many contacts the row is within its range if not at all.
std::string Recommend(double tolerance, double rate, std::vector<StudyRow>* rows);

struct StudySettings {
  double budget_s = 120;                          // of all candidates together [s]
  double timing_s = 0.15;                         // of repeated updates, per candidate [s]
  std::size_t max_memory = std::size_t{3} << 30;  // memory limit of one precompute [bytes]
  CandidateLimits limits = {};
  std::vector<Eigen::Vector3d> places = {};  // instead of the scene's own contact, see AskedOf
  bool compares = true;                      // false: measures only times, no errors
};

struct StudyResult {
  std::string scene_name;
  PressSpec question;
  double tolerance = 0, rate = 0, budget_s = 0;
  std::vector<StudyRow> rows;  // sorted by number; during the study in the order of the tests
  References references;
  std::string recommendation;  // one sentence
  bool complete = false;       // every candidate was tested
};

// StudyWatcher holds callbacks for a running study; both may be empty.
struct StudyWatcher {
  std::function<void(const StudyResult&)> on_row;  // called after every row with the present result
  Progress* progress = nullptr;
};

// Tests the cheapest candidates first (linear ones, which provide the reference, count a quarter).
// Expected costs are corrected by measured ones. Candidates that exceed the rest of the budget are
// listed as skipped with their expected cost. A stop ends it the same way. Throws
// std::invalid_argument: see AskedOf.
StudyResult RunStudy(const Scene& scene, const StudySettings& settings, const ModelFactory& factory,
                     const std::stop_token& stop = {}, const StudyWatcher& watcher = {});

}  // namespace palpate::study
