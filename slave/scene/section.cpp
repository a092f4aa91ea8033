#include "slave/scene/section.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Kind = DocumentNode::Kind;

// Returns the number of letters to change, add or drop between two words (Levenshtein).
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : a) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t swapped = diagonal + (letter == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({swapped, row[j + 1] + 1, row[j] + 1});
    }
  }
  return row.back();
}

std::string NearestOf(const std::vector<std::string>& known, std::string_view key) {
  constexpr std::size_t kMaxWordLength = 64;  // longer words are not compared with keys
  if (known.empty()) return "nothing here";
  std::string all;
  for (const auto& word : known) all.append(all.empty() ? "" : ", ").append(word);
  const auto distance = [&](const std::string& word) { return EditDistance(word, key); };
  const auto nearest =
      key.size() > kMaxWordLength ? known.end() : std::ranges::min_element(known, {}, distance);
  const bool is_near = nearest != known.end() && distance(*nearest) <= 1 + key.size() / 4;
  return (is_near ? "`" + *nearest + "` (nearest) or another of " : "one of ") + all;
}

}  // namespace

std::string AcceptedBy(const Rule& rule) {
  return ExpectedQuantity(rule.dimension, rule.range);
}

Section::Section(const DocumentNode* node, std::string path, Mistakes* mistakes,
                 DocumentNode::Kind kind)
    : node_(node), path_(std::move(path)), mistakes_(mistakes) {
  if (node_ != nullptr) is_asked_.resize(node_->children.size());
  if (node_ == nullptr || node_->kind == kind || node_->kind == Kind::kNothing) return;
  mistakes_->Add(*node_, path_, kind == Kind::kMap ? "a map of `key: value`" : "a list [...]");
  node_ = nullptr;
}

Section::~Section() {
  if (node_ == nullptr) return;
  for (std::size_t i = 0; i < is_asked_.size(); ++i) {
    if (is_asked_[i]) continue;
    const DocumentNode& child = node_->children[i];
    mistakes_->Add(child, PathOf(child.key),
                   mistakes_->is_full() ? std::string() : NearestOf(known_, child.key));
  }
}

std::string Section::PathOf(std::string_view key) const {
  std::string path = path_;
  return path.append(path.empty() ? "" : ".").append(key);
}

const DocumentNode* Section::Lookup(std::string_view key) {
  const DocumentNode* child = node_ == nullptr ? nullptr : node_->Find(key);
  if (child != nullptr) {
    const auto place = static_cast<std::size_t>(child - node_->children.data());
    if (is_asked_[place]) return child;
    is_asked_[place] = true;
  }
  const bool is_item = node_ != nullptr && node_->kind == Kind::kList;
  if (!is_item && std::ranges::find(known_, key) == known_.end()) known_.emplace_back(key);
  return child;
}

const DocumentNode* Section::Require(std::string_view key, std::string_view accepted,
                                     bool is_required) {
  const DocumentNode* child = Lookup(key);
  if (child == nullptr && is_required && present()) {
    mistakes_->AddMissing(*node_, PathOf(key), accepted);
  }
  return child;
}

bool Section::Has(std::string_view key) {
  return Lookup(key) != nullptr;
}

Section Section::Open(std::string_view key, std::string_view required) {
  return {Require(key, required, !required.empty()), PathOf(key), mistakes_};
}

Section Section::OpenList(std::string_view key, std::string_view required) {
  return {Require(key, required, !required.empty()), PathOf(key), mistakes_, Kind::kList};
}

std::optional<double> Section::Read(const DocumentNode& node, const std::string& path,
                                    const Rule& rule) {
  const auto value = node.kind == Kind::kScalar ? ParseQuantity(node.text, rule.dimension)
                                                : std::optional<double>();
  if (value && *value >= rule.least && *value <= rule.most) return value;
  mistakes_->Add(node, path, AcceptedBy(rule));
  return std::nullopt;
}

double Section::Number(std::string_view key, std::optional<double> fallback) {
  const SceneKey& row = SceneKeyAt(PathOf(key));
  if (!fallback && !row.defaults.empty()) fallback = row.defaults.front();
  if (!fallback && !row.is_required) fallback = 0;
  return NumberWithin(key, row.rule, fallback);
}

double Section::NumberWithin(std::string_view key, const Rule& rule,
                             std::optional<double> fallback) {
  const DocumentNode* child = Require(key, AcceptedBy(rule), !fallback.has_value());
  const auto value = child == nullptr ? std::nullopt : Read(*child, PathOf(key), rule);
  return value.value_or(fallback.value_or(0));
}

int Section::Integer(std::string_view key, std::optional<int> fallback) {
  const SceneKey& row = SceneKeyAt(PathOf(key));
  if (!fallback && !row.defaults.empty()) fallback = static_cast<int>(row.defaults.front());
  if (!fallback && !row.is_required) fallback = 0;
  return IntegerWithin(key, row.rule, fallback);
}

int Section::IntegerWithin(std::string_view key, const Rule& rule, std::optional<int> fallback) {
  const std::string accepted = Formatted("a whole number from %.0f to %.0f", rule.least, rule.most);
  const DocumentNode* child = Require(key, accepted, !fallback.has_value());
  if (child == nullptr) return fallback.value_or(0);
  const bool is_plain =
      ParseInteger(child->text).has_value() || rule.dimension != Dimension::kNumber;
  const auto value = is_plain ? ParseQuantity(child->text, rule.dimension) : std::nullopt;
  if (value && *value == std::floor(*value) && *value >= rule.least && *value <= rule.most) {
    return static_cast<int>(*value);
  }
  mistakes_->Add(*child, PathOf(key), accepted);
  return fallback.value_or(0);
}

std::string Section::Text(std::string_view key) {
  const SceneKey& row = SceneKeyAt(PathOf(key));
  return Text(key, row.range, row.is_required ? std::nullopt : std::optional(row.default_text));
}

std::string Section::Text(std::string_view key, std::string_view accepted,
                          const std::optional<std::string>& fallback) {
  const DocumentNode* child = Require(key, accepted, !fallback.has_value());
  if (child == nullptr) return fallback.value_or("");
  if (child->kind == Kind::kScalar && !child->text.empty()) return child->text;
  mistakes_->Add(*child, PathOf(key), accepted);
  return fallback.value_or("");
}

std::vector<double> Section::Numbers(std::string_view key, std::span<const Rule> rules,
                                     const std::optional<std::vector<double>>& fallback) {
  const std::string accepted =
      "a list of " + std::to_string(rules.size()) + " numbers, each " + AcceptedBy(rules.front());
  auto otherwise = fallback.value_or(std::vector<double>(rules.size(), 0.0));
  const DocumentNode* child = Require(key, accepted, !fallback.has_value());
  if (child == nullptr) return otherwise;
  if (child->kind != Kind::kList || child->children.size() != rules.size()) {
    mistakes_->Add(*child, PathOf(key), accepted);
    return otherwise;
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const DocumentNode& item = child->children[i];
    const auto value = Read(item, PathOf(key) + "." + item.key, rules[i]);
    values.push_back(value.value_or(otherwise[i]));
  }
  return values;
}

std::vector<double> Section::Vector(std::string_view key, std::size_t size,
                                    std::optional<std::vector<double>> fallback) {
  const SceneKey& row = SceneKeyAt(PathOf(key));
  if (!fallback && row.defaults.size() == size) fallback = row.defaults;
  return Numbers(key, std::vector(size, row.rule), fallback);
}

Eigen::Vector3d Section::Vector3(std::string_view key, std::optional<Eigen::Vector3d> fallback) {
  std::optional<std::vector<double>> numbers;
  if (fallback) numbers.emplace(fallback->begin(), fallback->end());
  const auto v = Vector(key, 3, std::move(numbers));
  return {v[0], v[1], v[2]};
}

Eigen::Vector2d Section::Vector2(std::string_view key, std::optional<Eigen::Vector2d> fallback) {
  std::optional<std::vector<double>> numbers;
  if (fallback) numbers.emplace(fallback->begin(), fallback->end());
  const auto v = Vector(key, 2, std::move(numbers));
  return {v[0], v[1]};
}

std::vector<Eigen::Vector2d> Section::Points(std::string_view key) {
  Section list =
      OpenList(key, "a list of points [x, y], each " + AcceptedBy(SceneKeyAt(PathOf(key)).rule));
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < list.size(); ++i) points.push_back(list.Vector2(std::to_string(i)));
  return points;
}

void Section::Refuse(std::string_view key, std::string_view accepted) {
  const DocumentNode* child = Lookup(key);
  if (child != nullptr) {
    mistakes_->Add(*child, PathOf(key), accepted);
  } else if (present()) {
    mistakes_->AddMissing(*node_, PathOf(key), accepted);
  }
}

}  // namespace palpate
