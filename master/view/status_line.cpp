#include "master/view/status_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace palpate {
namespace {

constexpr int kBar = 20;  // characters of the force bar

std::string Bar(double force, double limit) {
  const double share = limit > 0 ? std::clamp(force / limit, 0.0, 1.0) : 0;
  const auto full = static_cast<std::size_t>(std::lround(share * kBar));
  std::string bar = "[....................]";
  bar.replace(1, full, full, '#');
  return bar;
}

std::string OrDash(bool known, double value, const char* format) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);
  if (known) return text.data();
  const std::string numeral = text.data();
  return std::string(numeral.size() - 1, ' ').append("-");
}

}  // namespace

std::string FormatStatus(const Status& status) {
  const TickRecord& tick = status.tick;
  const double force = tick.chain.sent.norm();
  const bool timed = status.link.rtt_p50_us > 0;
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(), "%6.1f s  %-12s  %s Hz  RTT %s ms  age %s ms  %5.2f N %s", status.t,
      std::string(ToString(tick.state)).c_str(),
      OrDash(status.rate > 0, status.rate, "%4.0f").c_str(),
      OrDash(timed, status.link.rtt_p50_us / 1e3, "%5.2f").c_str(),
      OrDash(tick.state_age >= 0, std::clamp(tick.state_age, 0.0, 99.0) * 1e3, "%3.0f").c_str(),
      force, Bar(force, status.force_limit).c_str());
  std::string line = text.data();
  const std::string reasons = ToString(tick.chain.reasons);
  if (!reasons.empty()) line += "  " + reasons;
  if (!status.link.trouble.empty()) line += "  (" + status.link.trouble + ")";
  return line;
}

}  // namespace palpate
