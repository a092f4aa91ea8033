// An operator with the C++ client, for tests: script_operator HOST:PORT. Each line of the standard
// input is a command, and each is answered by one line: `ok`, the requested value, or `error: ...`.
//   engage    closes the clutch
//   release   opens it
//   change    sets the force limit to 3 N
//   idle N    waits for N states; prints the bytes that the program has in use then
#include <chrono>
#include <exception>
#include <iostream>
#include <string>
#include <thread>

#include <malloc.h>
#include <palpate/client.h>

namespace {

void SetForceLimit(const palpate::Slave& slave) {
  grpc::ClientContext context;
  palpate::v1::SetParametersRequest request;
  request.set_force_limit(3);
  palpate::v1::SettingsReply reply;
  const auto status = slave.stub().SetParameters(&context, request, &reply);
  if (!status.ok()) throw palpate::Error(status);
}

std::string Answer(const std::string& command, const palpate::Slave& slave,
                   palpate::Operator* tool) try {
  if (command == "engage") tool->Engage();
  if (command == "release") tool->Release();
  if (command == "change") SetForceLimit(slave);
  if (command.rfind("idle ", 0) == 0) {
    const auto end = tool->state().message().sequence() + std::stoull(command.substr(5));
    while (tool->state().message().sequence() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return std::to_string(mallinfo2().uordblks);
  }
  return "ok";
} catch (const std::exception& error) {
  return std::string("error: ") + error.what();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: script_operator HOST:PORT\n";
    return 2;
  }
  const palpate::Slave slave(argv[1]);
  const auto tool = slave.Operate("script_operator");
  std::cout << "ok" << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::cout << Answer(line, slave, tool.get()) << std::endl;
  }
  return 0;
} catch (const std::exception& error) {
  std::cout << "error: " << error.what() << std::endl;
  return 1;
}
