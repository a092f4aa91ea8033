// `palpate-master axes`: a wizard that finds the axes of a device.
#pragma once

#include <functional>
#include <string>

namespace palpate {

// Asks the operator to move the device to the right, up and forward, and prints `--axes=...`. No
// force is rendered. The exit code; throws as OpenDevice. `stopped`: polled.
int FindAxes(const std::string& device, const std::function<bool()>& stopped);

}  // namespace palpate
