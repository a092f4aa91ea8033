#include "tests/references/recorded_section.h"

namespace palpate {

std::vector<KeyRecord>& KeyRecords() {
  static std::vector<KeyRecord> records;
  return records;
}

KeyRecord Section::RecordOf(std::string_view key, std::string_view kind, std::string_view accepted,
                            Place place) const {
  return {.place = place,
          .path = PathOf(key),
          .kind = std::string(kind),
          .accepted = std::string(accepted)};
}

bool Section::Has(std::string_view key) {
  KeyRecords().push_back(RecordOf(key, "has", {}, Place::Here()));
  looked_for_.emplace(key);
  return PlainSection::Has(key);
}

Section Section::OpenKind(std::string_view key, std::string_view required, DocumentNode::Kind kind,
                          Place place) {
  const bool is_list = kind == DocumentNode::Kind::kList;
  KeyRecord record = RecordOf(key, is_list ? "list" : "map", required, place);
  record.is_required = !required.empty() && !looked_for_.contains(key);
  KeyRecords().push_back(record);
  if (!PlainSection::Has(key) && !required.empty()) Refuse(key, required);
  return {node() == nullptr ? nullptr : node()->Find(key), PathOf(key), mistakes(), kind};
}

Section Section::Open(std::string_view key, std::string_view required, Place place) {
  return OpenKind(key, required, DocumentNode::Kind::kMap, place);
}

Section Section::OpenList(std::string_view key, std::string_view required, Place place) {
  return OpenKind(key, required, DocumentNode::Kind::kList, place);
}

void Section::RecordNumbers(std::string_view key, std::string_view kind,
                            std::span<const Rule> rules,
                            const std::optional<std::vector<double>>& fallback, Place place) {
  KeyRecord record = RecordOf(key, kind, {}, place);
  for (const Rule& rule : rules) {
    record.units.push_back(AcceptedUnits(rule.dimension));
    const std::string range(rule.range);
    if (record.accepted.find(range) != std::string::npos) continue;
    record.accepted.append(record.accepted.empty() ? "" : ", ").append(range);
  }
  if (fallback) record.defaults = *fallback;
  record.is_required = !fallback && !looked_for_.contains(key);
  KeyRecords().push_back(record);
}

double Section::Number(std::string_view key, const Rule& rule, std::optional<double> fallback,
                       Place place) {
  RecordNumbers(key, "number", {&rule, 1},
                fallback ? std::optional(std::vector{*fallback}) : std::nullopt, place);
  return PlainSection::Number(key, rule, fallback);
}

int Section::Integer(std::string_view key, int least, int most, std::optional<int> fallback,
                     Dimension dimension, Place place) {
  const std::string range = std::to_string(least) + " to " + std::to_string(most);
  const Rule rule = Between(dimension, least, most, range);
  RecordNumbers(key, "integer", {&rule, 1},
                fallback ? std::optional(std::vector<double>{1.0 * *fallback}) : std::nullopt,
                place);
  return PlainSection::Integer(key, least, most, fallback, dimension);
}

std::string Section::Text(std::string_view key, std::string_view accepted,
                          const std::optional<std::string>& fallback, Place place) {
  KeyRecord record = RecordOf(key, "text", accepted, place);
  record.text = fallback;
  record.is_required = !fallback && !looked_for_.contains(key);
  KeyRecords().push_back(record);
  return PlainSection::Text(key, accepted, fallback);
}

std::vector<double> Section::Numbers(std::string_view key, std::span<const Rule> rules,
                                     const std::optional<std::vector<double>>& fallback,
                                     Place place) {
  RecordNumbers(key, "numbers", rules, fallback, place);
  return PlainSection::Numbers(key, rules, fallback);
}

Eigen::Vector3d Section::Vector3(std::string_view key, const Rule& rule,
                                 const Eigen::Vector3d& fallback, Place place) {
  RecordNumbers(key, "numbers", std::vector(3, rule),
                std::vector(fallback.data(), fallback.data() + 3), place);
  return PlainSection::Vector3(key, rule, fallback);
}

Eigen::Vector2d Section::Vector2(std::string_view key, const Rule& rule,
                                 std::optional<Eigen::Vector2d> fallback, Place place) {
  RecordNumbers(
      key, "numbers", std::vector(2, rule),
      fallback ? std::optional(std::vector(fallback->data(), fallback->data() + 2)) : std::nullopt,
      place);
  return PlainSection::Vector2(key, rule, fallback);
}

std::vector<Eigen::Vector2d> Section::Points(std::string_view key, const Rule& rule, Place place) {
  RecordNumbers(key, "points", std::vector(2, rule), std::nullopt, place);
  return PlainSection::Points(key, rule);
}

}  // namespace palpate
