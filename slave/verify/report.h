// A comparison of forces as JSON and as text.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "slave/verify/compare_forces.h"

namespace palpate {

// Comparisons by finger; an empty name is the only tool.
using Comparisons = std::map<std::string, ForceComparison>;

// The text of report.json. `scene`: the tested scene; `source`: source of its forces.
std::string ToJson(const std::string& scene, const std::string& source,
                   const Comparisons& comparisons);
// Writes folder/report.json where the slave refuses the samples of `scene`. Throws
// std::system_error.
void WriteRefusal(const std::string& scene, const std::string& why,
                  const std::filesystem::path& folder);
// Returns a table of verdicts and the likely causes.
std::string ToText(const Comparisons& comparisons);
// Returns whether no comparison found a fault; one that is not decided passes.
[[nodiscard]] bool Pass(const Comparisons& comparisons);

}  // namespace palpate
