#include "master/commands/signals.h"

#include <csignal>

namespace palpate {
namespace {

void OnSignal(int) {
  g_stop = true;
}

}  // namespace

void CatchSignals() {
  std::signal(SIGUSR1, [](int) { g_emergency = true; });
  std::signal(SIGUSR2, [](int) { g_reset = true; });
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  if (std::signal(SIGHUP, OnSignal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace palpate
