// Observes a slave: watch HOST:PORT [TLS_FOLDER]. Prints the states received and skipped. Exit
// code 0: the sequence increased throughout; 1: otherwise.
#include <cstdio>
#include <exception>

#include <palpate/client.h>

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: watch HOST:PORT [TLS_FOLDER]\n");
    return 2;
  }
  const palpate::Slave slave(argv[1], argc > 2 ? argv[2] : "");
  std::uint64_t first = 0, last = 0, states = 0;
  bool increases = true;
  slave.Watch(
      [&](const palpate::State& state) {
        const auto sequence = state.message().sequence();
        increases = increases && sequence > last;
        if (first == 0) first = sequence;
        last = sequence;
        return ++states < 100;
      },
      100);
  std::printf("%s: %lu states, %lu skipped\n", slave.Scene().name().c_str(), states,
              last - first + 1 - states);
  return increases ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
