// Cases of the reference tables in ../shared.
#pragma once

#include <fstream>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/support/paths.h"

namespace palpate {

// The case `id` of g_vision.json; nullopt where ../shared is absent.
inline std::optional<nlohmann::json> ReferenceCase(const std::string& id) {
  std::ifstream file(SourcePath("/../shared/reference/g_vision.json"));
  if (!file) return std::nullopt;
  const nlohmann::json table = nlohmann::json::parse(file);
  for (const nlohmann::json& entry : table.at("cases")) {
    if (entry.at("id") == id) return entry;
  }
  return std::nullopt;
}

}  // namespace palpate
