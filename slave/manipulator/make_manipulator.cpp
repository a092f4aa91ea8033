#include <utility>

#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "slave/manipulator/streamed_manipulator.h"

namespace palpate {

std::unique_ptr<Manipulator> MakeManipulator(const Scene& scene, Manipulator::OnStep on_step) {
  if (scene.manipulator.source == ManipulatorOptions::Source::kStream) {
    return std::make_unique<StreamedManipulator>(scene.manipulator, std::move(on_step));
  }
  return std::make_unique<SimulatedManipulator>(scene.manipulator, std::move(on_step));
}

}  // namespace palpate
