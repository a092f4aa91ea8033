#include "master/view/console.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <sys/ioctl.h>
#include <unistd.h>

#include "master/view/finger_text.h"
#include "shared/text/text.h"
#include "shared/wire/enum_names.h"

namespace palpate {
namespace {

constexpr double kLinePeriod = 1;  // between two lines in a pipe [s]

// Cuts lines to the terminal's width, because a wrapped line cannot be replaced, and their number
// to its height, because scrolled lines cannot be replaced either.
std::vector<std::string> Cut(std::vector<std::string> lines, std::FILE* out) {
  winsize size{};
  if (ioctl(fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return lines;
  for (std::string& line : lines) line = line.substr(0, size.ws_col - 1U);
  if (size.ws_row > 1 && lines.size() >= size.ws_row) lines.resize(size.ws_row - 1U);
  return lines;
}

constexpr int kBar = 20;  // characters of the force bar

std::string OrDash(bool known, double value, const char* format) {
  std::string numeral = Formatted(format, value);
  if (known) return numeral;
  return std::string(numeral.size() - 1, ' ').append("-");
}

constexpr int kMaxNameLength = 8;  // characters

std::string Name(const std::string& name) {
  std::string padded = name.substr(0, kMaxNameLength);
  padded.resize(kMaxNameLength, ' ');
  return "  " + padded + " ";
}

std::string Line(const NamedFinger& finger) {
  const FingerState& contact = finger.contact;
  if (!IsForceKnown(contact)) return Name(finger.name) + InWords(contact);
  const Eigen::Vector3d f = contact.force->cast<double>();
  std::string line = Name(finger.name) + Formatted("%-8s %8.3g N  (%+.3g %+.3g %+.3g) N",
                                                   contact.in_contact ? "contact" : "free",
                                                   f.norm(), f.x(), f.y(), f.z());
  if (contact.validity != Validity::kValid) line += "  " + std::string(ToString(contact.validity));
  return line;
}

std::string Moved(const RemoteMesh& mesh) {
  return Readable(1e3 * mesh.LargestDeflection()) + " mm";
}

class Table {
 public:
  void Row(const std::string& name, const std::string& value) {
    text_ += Formatted("  %-22s ", name.c_str()) + value + "\n";
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_ = "\n";
};

void AddTiming(const Report& r, Table* table) {
  table->Row("duration", Formatted("%.1f s", r.duration));
  table->Row("haptic loop", Formatted("%.1f Hz, %llu of %llu periods missed", r.rate(),
                                      static_cast<unsigned long long>(r.missed),
                                      static_cast<unsigned long long>(r.ticks + r.missed)));
  table->Row("wake-up delay",
             Formatted("median %.0f us, 99 %% below %.0f us, maximum %.0f us",
                       r.wake_us.Quantile(0.5), r.wake_us.Quantile(0.99), r.wake_us.max()));
  table->Row("tick computation",
             Formatted("median %.1f us, 99 %% below %.1f us", r.compute_us.Quantile(0.5),
                       r.compute_us.Quantile(0.99)));
  table->Row("round trip", Formatted("median %.2f ms, 99 %% below %.2f ms", r.link.rtt_p50_us / 1e3,
                                     r.link.rtt_p99_us / 1e3));
}

void AddForces(const Report& r, Table* table) {
  table->Row(r.truth_known ? "peak true force" : "peak estimated force",
             Formatted("%.3f N at the tool", r.force_peak));
  table->Row("peak force sent", Formatted("%.3f N at the device", r.force_sent_peak));
  if (r.force_error) {
    const double share = r.force_peak > 0 ? 100 / r.force_peak : 0;
    table->Row("force error",
               Formatted("rms %.4f N = %.2f %% of the peak, maximum %.4f N, %llu ticks",
                         r.force_error->rms, r.force_error->rms * share, r.force_error->peak,
                         static_cast<unsigned long long>(r.force_error->ticks)));
    if (r.let_go_ticks > 0) {
      table->Row("  while disengaged",
                 Formatted("%llu ticks in which the tool was in contact and no force was rendered; "
                           "the delay-compensated error excludes them",
                           static_cast<unsigned long long>(r.let_go_ticks)));
    }
  } else {
    table->Row("force error", "unknown: the slave reports no true force");
  }
  if (r.force_error_delay_compensated && r.force_peak > 0) {
    const auto& [later, first] = *r.force_error_delay_compensated;
    const double share = 100 / r.force_peak;
    table->Row("delay-compensated",
               (later.ticks > 0 ? Formatted("rms %.2f %% of the peak, ", share * later.rms) : "") +
                   Formatted("%.2f %% in the first contact, at the same commanded position",
                             share * first.rms));
  }
  if (r.breaking && r.force_peak > 0) {
    table->Row(
        "punctures",
        Formatted("%llu: rms %.1f %% of the peak from the puncture until the force is faded out, "
                  "%llu ticks at most",
                  static_cast<unsigned long long>(r.breaking->punctures),
                  100 / r.force_peak * r.breaking->error.rms,
                  static_cast<unsigned long long>(r.breaking->longest)));
  }
  for (const FingerReport& finger : r.fingers) {
    table->Row("finger " + finger.name, Formatted("in contact %.0f %% of the time, at most %.3f N",
                                                  100 * finger.contact_share, finger.force_peak));
  }
  if (r.shape) {
    table->Row("largest deflection",
               Formatted("%.2f mm in %llu meshes", 1e3 * r.shape->deflection_peak,
                         static_cast<unsigned long long>(r.shape->meshes)));
  }
  table->Row("minimum port energy", Formatted("%.2e J", r.energy_min));
}

}  // namespace

std::string ForceBar(double force, double limit, int width) {
  const double share = limit > 0 ? std::clamp(force / limit, 0.0, 1.0) : 0;
  const auto full = static_cast<std::size_t>(std::lround(share * width));
  return "[" + std::string(full, '#') + std::string(static_cast<std::size_t>(width) - full, '.') +
         "]";
}

Console Console::Standard() {
  return {stdout, isatty(STDOUT_FILENO) == 1};
}

void Console::Print(const std::string& line) {
  EndLine();
  std::fprintf(out_, "%s\n", line.c_str());
  std::fflush(out_);
}

void Console::Show(const SessionStatus& status, const RemoteMesh* mesh) {
  if (live_) {
    std::vector<std::string> lines{FormatStatus(status)};
    const auto table = FingerTable(status.fingers, mesh);
    lines.insert(lines.end(), table.begin(), table.end());
    return ShowLive(Cut(std::move(lines), out_));
  }
  if (state_ == status.tick.state && status.t - printed_at_ < kLinePeriod) return;
  state_ = status.tick.state;
  printed_at_ = status.t;
  Print(FormatStatus(status) + FingerBrief(status.fingers, mesh));
}

// Moves to the first of the shown lines, overwrites them and clears those that are left below.
void Console::ShowLive(const std::vector<std::string>& lines) {
  if (open_ > 1) std::fprintf(out_, "\x1b[%zuA", open_ - 1);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::fprintf(out_, "%s\r%s\x1b[K", i > 0 ? "\n" : "", lines[i].c_str());
  }
  if (open_ > lines.size()) std::fputs("\x1b[J", out_);
  std::fflush(out_);
  open_ = lines.size();
}

void Console::EndLine() {
  if (open_ > 0) std::fputc('\n', out_);
  open_ = 0;
}

std::string FormatStatus(const SessionStatus& status) {
  const TickRecord& tick = status.tick;
  const double force = tick.chain.sent.norm();
  const bool timed = status.link.rtt_p50_us > 0;
  std::string line = status.badge.empty() ? "" : status.badge + " ";
  line += Formatted(
      "%6.1f s  %-12s  %s Hz  RTT %s ms  age %s ms  %5.2f N %s", status.t,
      std::string(ToString(tick.state)).c_str(),
      OrDash(status.rate > 0, status.rate, "%4.0f").c_str(),
      OrDash(timed, status.link.rtt_p50_us / 1e3, "%5.2f").c_str(),
      OrDash(tick.state_age >= 0, std::clamp(tick.state_age, 0.0, 99.0) * 1e3, "%3.0f").c_str(),
      force, ForceBar(force, status.force_limit, kBar).c_str());
  const std::string reasons = InWords(tick.chain.reasons);
  if (!reasons.empty()) line += "  " + reasons;
  if (!status.link.trouble.empty()) line += "  (" + status.link.trouble + ")";
  return line;
}

std::vector<std::string> FingerTable(const std::vector<NamedFinger>& fingers,
                                     const RemoteMesh* mesh) {
  std::vector<std::string> lines;
  if (fingers.size() > 1) {
    for (const NamedFinger& finger : fingers) lines.push_back(Line(finger));
  }
  if (mesh == nullptr) return lines;
  lines.push_back(Name("object") + "moved by up to " + Moved(*mesh));
  if (mesh->validity != Validity::kValid) {
    lines.back() += "  " + std::string(ToString(mesh->validity));
  }
  return lines;
}

std::string FingerBrief(const std::vector<NamedFinger>& fingers, const RemoteMesh* mesh) {
  std::string line;
  if (fingers.size() > 1) {
    for (const NamedFinger& finger : fingers)
      line += "  " + finger.name + " " + InWords(finger.contact);
  }
  if (mesh != nullptr) line += "  moved " + Moved(*mesh);
  return line;
}

std::string FingertipsInWords(const std::vector<RemoteFingertip>& fingertips) {
  std::string words;
  for (const RemoteFingertip& tip : fingertips) {
    const std::string network =
        tip.network.empty() ? "no neural network: its force is unknown" : tip.network;
    words += (words.empty() ? "fingertips " : ", ") + tip.name + " (" + network + ")";
  }
  return words;
}

std::string FormatSummary(const Report& r) {
  Table table;
  table.Row("scene", r.scene + ", " + r.model);
  table.Row("device", r.device + "; rendering " + r.render);
  AddTiming(r, &table);
  AddForces(r, &table);
  std::string states;
  for (const auto& [name, seconds] : r.seconds_in) {
    states += (states.empty() ? "" : ", ") + name + Formatted(" %.1f s", seconds);
  }
  table.Row("operator states", states);
  table.Row("ticks clamped, stale",
            Formatted("%llu, %llu", static_cast<unsigned long long>(r.clamped_ticks),
                      static_cast<unsigned long long>(r.stale_ticks)));
  table.Row("states, reconnects",
            Formatted("%llu, %llu", static_cast<unsigned long long>(r.link.states),
                      static_cast<unsigned long long>(r.link.reconnects)));
  if (!r.realtime.empty()) table.Row("note", r.realtime);
  for (const std::string& trouble : r.trouble) table.Row("trouble", trouble);
  return table.text();
}

}  // namespace palpate
