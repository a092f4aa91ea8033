// Which rows nothing beats, which meet what the scene asks for, and which one to take.
#pragma once

#include <string>
#include <vector>

#include "slave/study/study_row.h"

namespace palpate::study {

// Marks the rows of smallest error for their update time (median), among those that answered with a
// known error and are within their range; of equal rows all are on the front.
void MarkFront(std::vector<StudyRow>* rows);

// Marks what meets the tolerance (its error, as known) and the rate [Hz] (its slowest percent), and
// recommends: of the rows that meet both and are at most twice as slow as the fastest of them, the
// one with the least precompute. None: the one that
// misses tolerance or rate by the smallest factor. Returns why, one sentence.
std::string Recommend(double tolerance, double rate, std::vector<StudyRow>* rows);

}  // namespace palpate::study
