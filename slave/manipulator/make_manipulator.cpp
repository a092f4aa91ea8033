#include "slave/manipulator/absent_manipulator.h"
#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "slave/manipulator/streamed_manipulator.h"

namespace palpate {

std::unique_ptr<Manipulator> MakeManipulator(const Scene& scene) {
  switch (scene.manipulator.source) {
    case ManipulatorOptions::Source::kStream:
      return std::make_unique<StreamedManipulator>(scene.manipulator);
    case ManipulatorOptions::Source::kNone:
      return std::make_unique<AbsentManipulator>(scene.manipulator);
    case ManipulatorOptions::Source::kSimulated:
      break;
  }
  return std::make_unique<SimulatedManipulator>(scene.manipulator);
}

}  // namespace palpate
