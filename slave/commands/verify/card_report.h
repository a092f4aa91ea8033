// The card as JSON and as text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slave/commands/verify/force_card.h"

namespace palpate {

// `scene`, `source`: what was tested, and where its states come from.
struct CardTitle {
  std::string scene, source;
};

// Writes folder/report.json. Throws std::runtime_error: not writable.
void WriteCards(const CardTitle& title, const std::vector<ForceCard>& cards,
                const std::filesystem::path& folder);
// The same file where the slave refuses the samples of `scene`. Throws std::runtime_error.
void WriteRefusal(const std::string& scene, const std::string& why,
                  const std::filesystem::path& folder);
// A table of verdicts, and what is likely wrong.
std::string ToText(const std::vector<ForceCard>& cards);

}  // namespace palpate
