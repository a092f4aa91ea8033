// Operates the slave at HOST:PORT until it is killed: the client that vanishes, for the tests.
#include <cstdio>

#include "tests/slave/service/service_fixture.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: lone_operator HOST:PORT\n", stderr);
    return 2;
  }
  palpate::Operator lone(palpate::v1::Teleoperation::NewStub(
      grpc::CreateChannel(argv[1], grpc::InsecureChannelCredentials())));
  while (lone.Hold(0, "lone") && lone.Read()) {
  }
  return 1;
}
