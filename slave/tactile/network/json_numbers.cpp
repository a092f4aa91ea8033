#include "slave/tactile/network/json_numbers.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "shared/text/text.h"

namespace palpate {
namespace {

using nlohmann::json;

constexpr std::uintmax_t kLargestFile = 256u << 20;  // [bytes]
constexpr int kLargestCount = 1 << 20;
constexpr double kLargestNumber = std::numeric_limits<float>::max();

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
    if (std::abs(number) > kLargestNumber) {
      throw std::runtime_error(entry + ": beyond single precision");
    }
    vector[static_cast<Eigen::Index>(i)] = static_cast<float>(number);
  }
  return vector;
}

// The shortest digits that single precision reads back, half as many as of the same number in
// double precision.
json NumbersOf(const Eigen::VectorXf& vector) {
  json list = json::array();
  for (const float number : vector) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.begin(), text.end(), number).ptr;
    double written = 0;
    std::from_chars(text.begin(), end, written);
    const bool reads_back =
        std::abs(written) <= kLargestNumber && static_cast<float>(written) == number;
    list.push_back(reads_back ? written : static_cast<double>(number));
  }
  return list;
}

}  // namespace palpate
