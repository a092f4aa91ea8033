#include "master/commands/replay_command.h"

#include <stdexcept>

#include "master/recording/replay.h"
#include "master/station/replay_station.h"
#include "master/view/console.h"
#include "shared/program/program.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

// The recording's description, one line each.
std::vector<std::string> Introduction(const ReplaySpan& span, const std::string& file) {
  std::vector<std::string> lines{Formatted("%s: %.1f s, %llu ticks", file.c_str(), span.seconds(),
                                           static_cast<unsigned long long>(span.ticks))};
  for (const auto& [key, value] : span.session) {
    lines.push_back("  " + Presentable(key, 40) + ": " + Presentable(value, 100));
  }
  if (!span.damage.empty()) lines.push_back("incomplete: " + span.damage);
  return lines;
}

void RequireWithin(const Replay& replay, double from) {
  if (from <= replay.span().seconds()) return;
  throw std::invalid_argument(Formatted("--from = %g s: expected up to the recording's end, %.1f s",
                                        from, replay.span().seconds()));
}

}  // namespace

int RunReplay(const ReplayOptions& options, const PagePlace& at, const std::stop_token& stop) {
  const Replay replay(options.file);
  RequireWithin(replay, options.from);
  Console console = Console::Standard();
  for (const std::string& line : Introduction(replay.span(), options.file.string())) {
    console.Print(line);
  }
  ReplayStation station(&replay,
                        {at, options.from, options.speed, options.file.string(), Version()});
  console.Print("view at " + station.address());
  station.Run(stop);
  return 0;
}

}  // namespace palpate
