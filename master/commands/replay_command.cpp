#include "master/commands/replay_command.h"

#include <stdexcept>

#include "master/recording/export.h"
#include "master/recording/replay.h"
#include "master/station/replay_station.h"
#include "master/view/console.h"
#include "shared/program/program.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kShowEvery = 0.1;  // of the player's time [s]

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

int RunReplay(const ReplayOptions& options, const std::stop_token& stop) {
  const Replay replay(options.file);
  RequireWithin(replay, options.from);
  Console console = Console::Standard();
  for (const std::string& line : Introduction(replay.span(), options.file.string())) {
    console.Print(line);
  }
  SessionStatus status;
  status.badge = "REPLAY";
  const auto limit = replay.span().session.find("force_limit_N");
  if (limit != replay.span().session.end()) {
    status.force_limit = ParseFinite(limit->second).value_or(0);
  }
  std::shared_ptr<const RemoteMesh> mesh;
  double shown = -1;
  std::uint64_t ticks = 0;
  ReplayFeed feed;
  feed.on_tick = [&](const TickRecord& tick) { status.tick = tick, ++ticks; };
  feed.on_state = [&](const SlaveState& state, Time) {
    TickRecord seen;
    RecordFingers(state, &seen);
    status.fingers = Named(seen, {});
  };
  feed.on_mesh = [&](const auto& newest) { mesh = newest; };
  feed.on_log = [&](const std::string& line, Time, bool) {
    console.Print(Formatted("REPLAY %6.1f s  ", status.t) + line);
  };
  feed.goes_on = [&](double t) {
    if (t - shown >= kShowEvery * options.speed && ticks > 0) {
      status.rate = shown >= 0 ? static_cast<double>(ticks) / (t - shown) : 0;
      shown = status.t = t;
      ticks = 0;
      console.Show(status, mesh.get());
    }
    return true;
  };
  replay.Play(options.from, options.speed, feed, stop);
  console.Print("end of the recording");
  return 0;
}

int ViewReplay(const ReplayOptions& options, const PagePlace& at, const std::stop_token& stop) {
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

int RunExport(const SessionExportOptions& options, const std::stop_token& stop) {
  const ExportCounts counts = ExportSession(options.file, options.out, stop);
  Console console = Console::Standard();
  console.Print(Formatted("%llu images, %llu meshes",
                          static_cast<unsigned long long>(counts.images),
                          static_cast<unsigned long long>(counts.meshes)));
  if (!counts.damage.empty()) console.Print("incomplete: " + counts.damage);
  console.Print("written: " + options.out.string());
  return 0;
}

}  // namespace palpate
