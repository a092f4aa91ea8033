// A master without a hand: connects to HOST:PORT, operates for a second, prints what came. Exit
// code 0: states came; 1: none, or nobody there.
#include <cstdio>
#include <exception>
#include <string_view>
#include <thread>

#include "master/link/slave_link.h"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: link_probe HOST:PORT [--insecure]\n", stderr);
    return 2;
  }
  palpate::SlaveLink::Options options;
  options.target = argv[1];
  options.insecure = argc > 2 && std::string_view(argv[2]) == "--insecure";
  options.operator_name = "link_probe";
  try {
    palpate::LatestValue<palpate::ReceivedState> states;
    palpate::LatestValue<palpate::OperatorCommand> commands;
    palpate::LatestValue<palpate::RemoteSettings> settings;
    palpate::SlaveLink link(options);
    const palpate::RemoteScene scene = link.Connect();
    link.Start(&states, &commands, &settings);
    palpate::OperatorCommand command;
    for (int tick = 0; tick < 1000; ++tick) {
      ++command.sequence;
      commands.Put(command);
      states.Take();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const palpate::LinkStats stats = link.stats();
    std::printf("%s: %llu states, %llu commands, round trip %.0f us\n", scene.name.c_str(),
                static_cast<unsigned long long>(stats.states),
                static_cast<unsigned long long>(stats.commands), stats.rtt_p50_us);
    return stats.states > 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
