// Reads cases of the physics references in ../shared.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/paths.h"

namespace palpate::reference {

using nlohmann::json;

// Reads a file of ../shared/reference; nullopt if it is absent.
inline std::optional<json> Load(const std::string& file) {
  std::ifstream stream(std::filesystem::path(SourcePath("/../shared/reference")) / file);
  if (!stream) return std::nullopt;
  return json::parse(stream);
}

inline json CaseOf(const json& file, const std::string& id) {
  for (const auto& c : file.at("cases")) {
    if (c.at("id") == id) return c;
  }
  ADD_FAILURE() << "no case " << id;
  return {};
}

// Reads a case of a file of ../shared/reference; nullopt if the file is absent.
inline std::optional<json> Find(const std::string& file, const std::string& id) {
  const auto all = Load(file);
  return all ? std::optional(CaseOf(*all, id)) : std::nullopt;
}

inline Eigen::Vector3d VectorOf(const json& numbers) {
  return {numbers.at(0).get<double>(), numbers.at(1).get<double>(), numbers.at(2).get<double>()};
}

}  // namespace palpate::reference

#define PALPATE_FOUND_OR_SKIP(variable, found)                            \
  const auto variable##_found = palpate::reference::found;                \
  if (!variable##_found) GTEST_SKIP() << "../shared/reference is absent"; \
  const auto& variable = *variable##_found

#define PALPATE_REFERENCE_OR_SKIP(variable, file) PALPATE_FOUND_OR_SKIP(variable, Load(file))
#define PALPATE_CASE_OR_SKIP(variable, file, id) PALPATE_FOUND_OR_SKIP(variable, Find(file, id))
