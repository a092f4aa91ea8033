// A slave without pictures (see FakeSlave) that senses 60 times a second, for the scripted clients.
//   fake_slave_server [ADDRESS] [--insecure | --tactile | --devices]
// --tactile: fed by fingers rf and th; --devices: by a camera's driver, with an arm that another
// drives. Prints `listening on HOST:PORT` and serves until SIGTERM or SIGINT.
#include <csignal>
#include <cstdio>
#include <exception>
#include <string_view>
#include <thread>

#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"

int main(int argc, char** argv) {
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGTERM);
  sigaddset(&ending, SIGINT);
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);  // before any thread is made

  const char* const address = argc > 1 ? argv[1] : "127.0.0.1:0";
  const bool insecure = argc > 2 && std::string_view(argv[2]) == "--insecure";
  try {
    palpate::FakeSlave slave;
    if (argc > 2 && std::string_view(argv[2]) == "--tactile") slave.TakeTactile({"rf", "th"});
    if (argc > 2 && std::string_view(argv[2]) == "--devices") {
      slave.TakePictures();
      slave.TakeArm({});
    }
    palpate::Server server(slave, address, insecure);
    const std::jthread camera([&slave](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        slave.TakeSample();
        std::this_thread::sleep_for(std::chrono::milliseconds(16));
      }
    });
    std::printf("listening on %s\n", server.address().c_str());
    std::fflush(stdout);
    int signal = 0;
    sigwait(&ending, &signal);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
