#include "slave/commands/plain_words.h"

#include <algorithm>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/scene/words.h"
#include "slave/study/auto_model.h"

namespace palpate {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2]

struct Familiar {
  double below;  // Young's modulus [Pa]
  const char* thing;
};
// [paper: Young's moduli of tissues and elastomers in common tables; orders of magnitude]
constexpr Familiar kFamiliar[] = {
    {2e3, "jelly that hardly stands"},
    {1e4, "jelly, or the liver of an animal"},
    {4e4, "a marshmallow, or a relaxed muscle"},
    {2e5, "a gummy bear"},
    {1e6, "a soft eraser"},
    {5e6, "a rubber band"},
    {5e7, "the sole of a shoe"},
    {1e9, "a plastic bag"},
    {1e10, "a plastic ruler"},
};

std::string Sizes(const Scene& scene) {
  return fmt::format("{}, about as stiff as {}", InWords(scene.object.geometry),
                     StiffAs(scene.object.material.young_modulus));
}

}  // namespace

std::string StiffAs(double young_modulus) {
  for (const auto& [below, thing] : kFamiliar) {
    if (young_modulus < below) return thing;
  }
  return "stone or metal";
}

std::string ForceInPlainWords(double newtons) {
  const double grams = 1e3 * newtons / kGravity;
  return fmt::format("{:.2g} N, the weight of {} g", newtons,
                     grams < 10 ? fmt::format("{:.2g}", grams) : fmt::format("{:.0f}", grams));
}

std::string InPlainWords(const Scene& scene, const study::PressSpec& spec,
                         DeformationModel* model) {
  constexpr double kMillimetre = 1e-3;
  const double depth = std::min(kMillimetre, spec.depth);
  const study::Press& press = spec.presses.front();
  const Tool tool = scene.tool.value_or(Tool{.width = spec.width});
  const Contact contact{
      .p_O = press.p_O, .width = spec.width, .prescribed_O = depth * press.inward_O};
  Solution solution;
  model->Reset();
  const ContactResponse response =
      ToolPress(scene, tool, MeshObject(scene, std::nullopt)).Press(contact, model, &solution);
  model->Reset();
  return fmt::format("{}; {} deep the tool presses with {}", Sizes(scene), LengthInWords(depth),
                     ForceInPlainWords(press.inward_O.dot(response.force_O)));
}

std::string InPlainWords(const Scene& scene) {
  const bool is_quick = !IsVolume(scene.object.geometry) && study::CanStudy(scene);
  if (!is_quick) return Sizes(scene);
  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
  return InPlainWords(scene, study::AskedOf(scene), model.get());
}

std::string InPlainWords(double young_modulus) {
  constexpr double kEdge = 0.01, kPressed = 0.001;  // [m]
  return fmt::format(
      "about as stiff as {}; a cube of 10 mm, pressed by 1 mm between two plates, "
      "takes about {}",
      StiffAs(young_modulus), ForceInPlainWords(young_modulus * kEdge * kEdge * kPressed / kEdge));
}

}  // namespace palpate
