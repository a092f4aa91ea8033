#include <utility>

#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/serial_manipulator.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "slave/manipulator/streamed_manipulator.h"

namespace palpate {

std::unique_ptr<Manipulator> MakeManipulator(const Scene& scene, Manipulator::OnStep on_step) {
  using Source = ManipulatorOptions::Source;
  switch (scene.manipulator.source) {
    case Source::kSimulated:
      break;
    case Source::kStream:
      return std::make_unique<StreamedManipulator>(scene.manipulator, std::move(on_step));
    case Source::kMp285:
      return std::make_unique<SerialManipulator>(scene.manipulator, std::move(on_step));
  }
  return std::make_unique<SimulatedManipulator>(scene.manipulator, std::move(on_step));
}

}  // namespace palpate
