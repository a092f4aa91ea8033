#include "shared/metrics/metric.h"

#include <cmath>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kLongestValue = 200;  // [characters]

void AppendValue(double value, std::string* text) {
  if (std::isnan(value)) {
    *text += "NaN\n";
  } else if (std::isinf(value)) {
    *text += value > 0 ? "+Inf\n" : "-Inf\n";
  } else {
    AppendNumber(value, '\n', text);
  }
}

void Append(const Metric& metric, std::string* text) {
  *text += "# HELP " + metric.name + ' ' + metric.help + '\n';
  *text +=
      "# TYPE " + metric.name + (metric.type == Metric::Type::kCounter ? " counter\n" : " gauge\n");
  for (const Metric::Sample& sample : metric.samples) {
    *text += metric.name;
    if (!sample.label.empty()) *text += '{' + sample.label + '}';
    *text += ' ';
    AppendValue(sample.value, text);
  }
}

}  // namespace

std::string Label(std::string_view name, std::string_view value) {
  std::string label = std::string(name) + "=\"";
  for (const char c : Presentable(value, kLongestValue)) {
    if (c == '"' || c == '\\') label += '\\';
    label += c;
  }
  return label + '"';
}

Metric Gauge(std::string name, std::string help, double value) {
  return {std::move(name), std::move(help), Metric::Type::kGauge, {{"", value}}};
}

Metric Counter(std::string name, std::string help, double value) {
  return {std::move(name), std::move(help), Metric::Type::kCounter, {{"", value}}};
}

std::string ToText(const Metrics& metrics) {
  std::string text;
  for (const Metric& metric : metrics) Append(metric, &text);
  return text;
}

}  // namespace palpate
