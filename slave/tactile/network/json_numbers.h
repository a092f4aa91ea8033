// Numbers from JSON, with errors that name the position. Private to this folder's sources.
#pragma once

#include <filesystem>
#include <string>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace palpate {

// Throws std::runtime_error naming the file: missing, larger than a network can be, not JSON.
nlohmann::json ReadJsonFile(const std::filesystem::path& file);

// The functions below throw std::runtime_error naming `name` or `name.key` and what is accepted.
const nlohmann::json& Member(const nlohmann::json& object, const std::string& key,
                             const std::string& name);
double ReadNumber(const nlohmann::json& value, const std::string& name);
int ReadCount(const nlohmann::json& object, const std::string& key);
std::string ReadText(const nlohmann::json& object, const std::string& key);
// Numbers that fit into single precision.
Eigen::VectorXf ReadNumbers(const nlohmann::json& list, const std::string& name);
nlohmann::json NumbersOf(const Eigen::VectorXf& vector);

}  // namespace palpate
