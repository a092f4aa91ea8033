#include <stdexcept>

#include "slave/tactile/network/network_file.h"
#include "slave/tactile/network/onnx_network.h"
#include "slave/tactile/network/tensors_file.h"

namespace palpate {

std::unique_ptr<ForceNetwork> LoadForceNetwork(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw std::runtime_error(path.string() + ": there is no such file or folder");
  }
  if (!std::filesystem::is_directory(path, ignored)) return LoadOnnxNetwork(path);
  const bool own = std::filesystem::exists(path / kNetworkFileName, ignored);
  if (!own && !std::filesystem::exists(path / kTensorsFileName, ignored)) {
    throw std::runtime_error(path.string() + ": holds neither " + kNetworkFileName + " nor " +
                             kTensorsFileName);
  }
  const NetworkFile file = own ? ReadForceNetwork(path) : ImportTensors(path);
  return MakeForceNetwork(file.info, file.weights);
}

}  // namespace palpate
