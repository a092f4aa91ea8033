#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "slave/manipulator/streamed_manipulator.h"

namespace palpate {

std::unique_ptr<Manipulator> MakeManipulator(const Scene& scene) {
  if (scene.manipulator.source == ManipulatorOptions::Source::kStream) {
    return std::make_unique<StreamedManipulator>(scene.manipulator);
  }
  return std::make_unique<SimulatedManipulator>(scene.manipulator);
}

}  // namespace palpate
