// What a simulated experiment came to, for people and for programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slave/study/shape/simulated_experiment.h"

namespace palpate::study {

// One line per object and state: octree score with its spread, distances.
std::string ToTable(const std::vector<SimulatedObject>& objects);
// Figure 13: octree scores of every object's three states, dots for means, bars from the lowest to
// the highest repetition; rings for what the shape at rest would score in the deformed state. An
// SVG document.
std::string DrawScores(const std::vector<SimulatedObject>& objects);
// Writes report.json and report.html with the pictures of all states. False: cannot be written.
bool WriteSimulated(const std::vector<SimulatedObject>& objects, const DepthCamera& camera,
                    double leaf, const std::filesystem::path& folder);

}  // namespace palpate::study
