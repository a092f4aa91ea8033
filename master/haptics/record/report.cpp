#include "master/haptics/record/report.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// Six digits: more would be noise.
double Tidy(double value) {
  if (!std::isfinite(value)) return 0;
  if (value == 0) return 0;
  const double scale = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  const double tidy = std::round(value * scale) / scale;
  return std::isfinite(tidy) ? tidy : value;
}

Json Times(const LatencyHistogram& times) {
  return {{"p50", Tidy(times.Quantile(0.5))},
          {"p99", Tidy(times.Quantile(0.99))},
          {"p999", Tidy(times.Quantile(0.999))},
          {"max", Tidy(times.max())}};
}

Json ErrorOf(const Report& report) {
  if (!report.force_error) return nullptr;
  const ForceError::Summary& error = *report.force_error;
  Json json{
      {"rms_N", Tidy(error.rms)}, {"peak_N", Tidy(error.peak)}, {"contact_ticks", error.ticks}};
  json["relative_rms"] = report.force_peak > 0 ? Json(Tidy(error.rms / report.force_peak)) : Json();
  return json;
}

Json FingersOf(const Report& report) {
  Json fingers = Json::array();
  for (const FingerReport& finger : report.fingers) {
    fingers.push_back({{"name", finger.name},
                       {"contact_share", Tidy(finger.contact_share)},
                       {"force_peak_N", Tidy(finger.force_peak)}});
  }
  return fingers;
}

}  // namespace

std::string ToJson(const Report& report) {
  Json json;
  json["duration_s"] = Tidy(report.duration);
  json["ticks"] = report.ticks;
  json["missed"] = report.missed;
  json["rate_hz"] = Tidy(report.rate());
  json["bare_loop"] = {{"missed", report.bare_median()}, {"missed_each", report.bare_missed}};
  json["wake_us"] = Times(report.wake_us);
  json["compute_us"] = Times(report.compute_us);
  json["rtt_us"] = {{"p50", Tidy(report.link.rtt_p50_us)},
                    {"p99", Tidy(report.link.rtt_p99_us)},
                    {"max", Tidy(report.link.rtt_max_us)}};
  json["states"] = report.link.states;
  json["reconnects"] = report.link.reconnects;
  json["force_peak_N"] = Tidy(report.force_peak);
  json["force_peak_is"] = report.truth_known ? "true" : "estimated";
  json["force_sent_peak_N"] = Tidy(report.force_sent_peak);
  json["force_error"] = ErrorOf(report);
  if (!report.fingers.empty()) json["fingers"] = FingersOf(report);
  if (report.shape) {
    json["shape"] = {{"meshes", report.shape->meshes},
                     {"deflection_peak_m", Tidy(report.shape->deflection_peak)}};
  }
  json["energy_min_J"] = Tidy(report.energy_min);
  json["clamped_ticks"] = report.clamped_ticks;
  json["stale_ticks"] = report.stale_ticks;
  json["state"] = ToString(report.state);
  json["render"] = report.render;
  json["epochs"] = report.epochs;
  json["commands"] = report.link.commands;
  json["clock_offset_s"] = Tidy(report.link.clock_offset);
  json["seconds_in"] = report.seconds_in;
  json["reasons"] = report.reasons;
  json["records_dropped"] = report.records_dropped;
  json["scene"] = report.scene;
  json["model"] = report.model;
  json["device"] = report.device;
  json["realtime"] = report.realtime;
  json["trouble"] = report.trouble;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void WriteReport(const Report& report, const std::filesystem::path& file) {
  ReplaceFile(file, ToJson(report));
}

}  // namespace palpate
