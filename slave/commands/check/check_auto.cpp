#include "slave/commands/check/check_auto.h"

#include <exception>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "slave/study/quick_choice.h"

namespace palpate {
namespace {

std::string Words(const Scene& scene) {
  if (std::holds_alternative<ImageContourGeometry>(scene.object.geometry)) {
    return "nothing to study before the contour is found";
  }
  try {
    const auto choice = study::ChooseQuickly(scene, study::RealWorkshop());
    return choice ? choice->reason : "no model answered within a quick study";
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

void PrintAuto(const Scene& scene) {
  fmt::print("  {:<14} {}\n", "quick study", Words(scene));
}

}  // namespace palpate
