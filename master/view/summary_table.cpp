#include "master/view/summary_table.h"

#include <cstdarg>
#include <cstdio>

namespace palpate {
namespace {

// printf into a string.
__attribute__((format(printf, 1, 2))) std::string Text(const char* format, ...) {
  std::string text(160, '\0');
  va_list arguments;
  va_start(arguments, format);
  const int size = std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  text.resize(std::min(text.size() - 1, static_cast<std::size_t>(std::max(size, 0))));
  return text;
}

class Table {
 public:
  void Row(const std::string& name, const std::string& value) {
    text_ += Text("  %-22s ", name.c_str()) + value + "\n";
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_ = "\n";
};

void AddTiming(const Report& r, Table* table) {
  table->Row("duration", Text("%.1f s", r.duration));
  table->Row("haptic loop",
             Text("%.1f Hz, missed %llu of %llu; an empty loop beside it missed %llu", r.rate(),
                  static_cast<unsigned long long>(r.missed),
                  static_cast<unsigned long long>(r.ticks + r.missed),
                  static_cast<unsigned long long>(r.bare_median())));
  table->Row("woken late by",
             Text("%.0f us half the time, 99 %% under %.0f us, worst %.0f us",
                  r.wake_us.Quantile(0.5), r.wake_us.Quantile(0.99), r.wake_us.max()));
  table->Row("computing a tick", Text("%.1f us half the time, 99 %% under %.1f us",
                                      r.compute_us.Quantile(0.5), r.compute_us.Quantile(0.99)));
  table->Row("round trip", Text("%.2f ms half the time, 99 %% under %.2f ms",
                                r.link.rtt_p50_us / 1e3, r.link.rtt_p99_us / 1e3));
}

void AddForces(const Report& r, Table* table) {
  table->Row(r.truth_known ? "peak true force" : "peak estimated force",
             Text("%.3f N at the tool", r.force_peak));
  table->Row("peak force sent", Text("%.3f N at the hand", r.force_sent_peak));
  if (r.force_error) {
    const double share = r.force_peak > 0 ? 100 / r.force_peak : 0;
    table->Row("force error",
               Text("rms %.4f N = %.2f %% of the peak, worst %.4f N, %llu ticks",
                    r.force_error->rms, r.force_error->rms * share, r.force_error->peak,
                    static_cast<unsigned long long>(r.force_error->ticks)));
  } else {
    table->Row("force error", "not known: the slave's site tells no true force");
  }
  for (const FingerReport& finger : r.fingers) {
    table->Row("finger " + finger.name, Text("touched %.0f %% of the time, at most %.3f N",
                                             100 * finger.contact_share, finger.force_peak));
  }
  if (r.shape) {
    table->Row("largest deflection", Text("%.2f mm in %llu meshes", 1e3 * r.shape->deflection_peak,
                                          static_cast<unsigned long long>(r.shape->meshes)));
  }
  table->Row("least energy at port", Text("%.2e J", r.energy_min));
}

}  // namespace

std::string FormatSummary(const Report& r) {
  Table table;
  table.Row("scene", r.scene + ", " + r.model);
  table.Row("device", r.device + "; rendering " + r.render);
  AddTiming(r, &table);
  AddForces(r, &table);
  std::string states;
  for (const auto& [name, seconds] : r.seconds_in) {
    states += (states.empty() ? "" : ", ") + name + Text(" %.1f s", seconds);
  }
  table.Row("operator states", states);
  table.Row("ticks clamped, stale",
            Text("%llu, %llu", static_cast<unsigned long long>(r.clamped_ticks),
                 static_cast<unsigned long long>(r.stale_ticks)));
  table.Row("states, reconnects", Text("%llu, %llu", static_cast<unsigned long long>(r.link.states),
                                       static_cast<unsigned long long>(r.link.reconnects)));
  if (!r.realtime.empty()) table.Row("note", r.realtime);
  for (const std::string& trouble : r.trouble) table.Row("trouble", trouble);
  return table.text();
}

}  // namespace palpate
