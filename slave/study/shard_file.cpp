#include "slave/study/shard_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <stdexcept>
#include <string_view>

#include <nlohmann/json.hpp>

#include "slave/study/report.h"

namespace palpate::study {
namespace {

using Json = nlohmann::ordered_json;

// Null: not a number.
double NumberFrom(const Json& json) {
  return json.is_null() ? kUnknown : json.get<double>();
}

template <typename Value>
Value NamedBy(const Json& json, std::initializer_list<Value> values) {
  for (const Value value : values) {
    if (json.get<std::string>() == ToString(value)) return value;
  }
  throw std::invalid_argument(json.dump());
}

Validity ValidityFrom(const Json& json) {
  using enum Validity;
  return NamedBy(json, {kValid, kExtrapolated, kPunctured, kStale, kTrackingLost, kFailed});
}

Answer AnswerFrom(const Json& json) {
  return {.value = NumberFrom(json.at("value")),
          .validity = ValidityFrom(json.at("validity")),
          .bound = NumberFrom(json.at("stated_error"))};
}

StudyRow RowFrom(const Json& json) {
  using enum Outcome;
  StudyRow row;
  json.at("number").get_to(row.number);
  json.at("family").get_to(row.family);
  json.at("resolution").get_to(row.resolution);
  json.at("dof").get_to(row.dof);
  row.expected_s = NumberFrom(json.at("expected_s"));
  row.outcome = NamedBy(json.at("outcome"), {kAnswered, kFailed, kSkipped});
  json.at("reason").get_to(row.reason);
  for (const Json& answer : json.at("answers")) {
    row.answers.push_back({.small = AnswerFrom(answer.at("small")),
                           .full = AnswerFrom(answer.at("full")),
                           .width_mismatch = NumberFrom(answer.at("width_mismatch")),
                           .width_slope = NumberFrom(answer.at("width_slope"))});
    row.beyond += row.answers.back().full.validity == Validity::kValid ? 0 : 1;
  }
  row.stated_error = NumberFrom(json.at("stated_error"));
  row.precompute_s = NumberFrom(json.at("precompute_s"));
  row.update_median_s = NumberFrom(json.at("update_s").at("median"));
  row.update_p99_s = NumberFrom(json.at("update_s").at("p99"));
  json.at("memory_bytes").get_to(row.memory_bytes);
  row.validity = ValidityFrom(json.at("validity"));
  return row;
}

}  // namespace

std::string ToJson(const ShardFile& shard) {
  const Json json{{"conditions", shard.conditions},
                  {"processor", shard.processor},
                  {"study", Json::parse(ToJson(shard.study))}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

ShardFile ReadShard(const std::filesystem::path& file) try {
  ShardFile shard;
  const Json json = Json::parse(std::ifstream(file, std::ios::binary));
  json.at("conditions").get_to(shard.conditions);
  json.at("processor").get_to(shard.processor);
  const Json& study = json.at("study");
  study.at("complete").get_to(shard.study.complete);
  study.at("settings").at("budget_s").get_to(shard.study.budget_s);
  for (const Json& row : study.at("rows")) shard.study.rows.push_back(RowFrom(row));
  return shard;
} catch (const std::exception& error) {
  throw std::invalid_argument(file.string() +
                              ": expected a file of study --shard: " + error.what());
}

}  // namespace palpate::study
