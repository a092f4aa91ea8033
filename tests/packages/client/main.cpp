// Reads fifty states of the slave at HOST:PORT and prints how many arrived.
#include <cstdio>

#include <grpcpp/grpcpp.h>
#include <palpate/v1/teleoperation.grpc.pb.h>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  namespace v1 = palpate::v1;
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  const auto slave = v1::Teleoperation::NewStub(
      grpc::CreateCustomChannel(argv[1], grpc::InsecureChannelCredentials(), arguments));
  grpc::ClientContext asking;
  v1::SceneDescription scene;
  if (!slave->GetScene(&asking, {}, &scene).ok()) return 1;
  grpc::ClientContext watching;
  const auto stream = slave->WatchState(&watching, {});
  v1::SlaveState state;
  int states = 0;
  while (states < 50 && stream->Read(&state)) ++states;
  watching.TryCancel();
  std::printf("%s: %d states, the last with validity %d\n", scene.name().c_str(), states,
              static_cast<int>(state.validity()));
  return states == 50 ? 0 : 1;
}
