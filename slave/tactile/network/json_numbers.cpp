#include "slave/tactile/network/json_numbers.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "shared/text/text.h"

namespace palpate {
namespace {

using nlohmann::json;

constexpr std::uintmax_t kLargestFile = 256u << 20;  // [bytes]
constexpr int kLargestCount = 1 << 20;

}  // namespace

json ReadJsonFile(const std::filesystem::path& file) {
  const std::string text = ReadWholeFile(file, kLargestFile, "JSON");
  try {
    return json::parse(text);
  } catch (const json::exception& broken) {
    throw std::runtime_error(file.string() + ": not JSON: " + broken.what());
  }
}

const json& Member(const json& object, const std::string& key, const std::string& name) {
  const std::string full = name.empty() ? key : name + "." + key;
  if (!object.is_object() || !object.contains(key)) throw std::runtime_error(full + " is missing");
  return object[key];
}

double ReadNumber(const json& value, const std::string& name) {
  if (!value.is_number()) throw std::runtime_error(name + ": not a number");
  const auto number = value.get<double>();
  if (!std::isfinite(number)) throw std::runtime_error(name + ": not a finite number");
  return number;
}

int ReadCount(const json& object, const std::string& key) {
  const double number = ReadNumber(Member(object, key, ""), key);
  if (!(number >= 0 && number <= kLargestCount && number == std::floor(number))) {
    throw std::runtime_error(key + ": not a count from 0 to " + std::to_string(kLargestCount));
  }
  return static_cast<int>(number);
}

std::string ReadText(const json& object, const std::string& key) {
  const json& value = Member(object, key, "");
  if (!value.is_string()) throw std::runtime_error(key + ": not a text");
  return value.get<std::string>();
}

Eigen::VectorXf ReadNumbers(const json& list, const std::string& name) {
  if (!list.is_array()) throw std::runtime_error(name + ": not a list of numbers");
  Eigen::VectorXf vector(static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string entry = name + "[" + std::to_string(i) + "]";
    const double number = ReadNumber(list[i], entry);
    if (std::abs(number) > static_cast<double>(std::numeric_limits<float>::max())) {
      throw std::runtime_error(entry + ": beyond single precision");
    }
    vector[static_cast<Eigen::Index>(i)] = static_cast<float>(number);
  }
  return vector;
}

json NumbersOf(const Eigen::VectorXf& vector) {
  json list = json::array();
  for (const float number : vector) list.push_back(static_cast<double>(number));
  return list;
}

}  // namespace palpate
