#include "slave/tactile/localise/localiser.h"

#include <filesystem>
#include <stdexcept>

#include "slave/tactile/localise/direction_localiser.h"
#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/localise/paper_localiser.h"

namespace palpate {
namespace {

bool NamesFile(const std::string& localise) {
  const std::filesystem::path path(localise);
  return path.has_extension() || path.has_parent_path();
}

std::unique_ptr<Localiser> FromFile(const std::filesystem::path& file, double finger_radius) {
  try {
    return MakeFittedLocaliser(ReadLocaliser(file), finger_radius);
  } catch (const std::invalid_argument& wrong) {
    throw std::runtime_error(file.string() + ": " + wrong.what());
  }
}

}  // namespace

std::unique_ptr<Localiser> MakeLocaliser(const Tactile& tactile, const ElectrodeLayout& layout) {
  using Weighting = DirectionLocaliser::Weighting;
  const std::string& name = tactile.localise;
  if (name == "paper") return std::make_unique<PaperLocaliser>(tactile, layout);
  if (name == "auto" || name == "pressure-weighted") {
    return std::make_unique<DirectionLocaliser>(tactile, layout, Weighting::kPressureWeighted);
  }
  if (name == "polarity-free") {
    return std::make_unique<DirectionLocaliser>(tactile, layout, Weighting::kPolarityFree);
  }
  if (NamesFile(name)) return FromFile(name, tactile.finger_radius);
  throw std::invalid_argument("localise = " + name +
                              ": accepted is auto, paper, polarity-free, pressure-weighted or the "
                              "file of a fitted localiser");
}

}  // namespace palpate
