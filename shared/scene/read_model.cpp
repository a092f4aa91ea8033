#include "shared/scene/sections.h"

namespace palpate {

ModelOptions ReadModel(Section& scene) {
  using Kind = Section::Choice<const char*>;
  using Order = Section::Choice<int>;
  using PlaneChoice = Section::Choice<Plane>;
  using Contact = Section::Choice<ContactLaw>;
  constexpr std::string_view kNow = " in this version";
  const Rule share = Between(Dimension::kNumber, 1e-6, 1, "> 0 (1e-6 to 1)");

  Section model = scene.Open("model", "a map of kind, elements, plane, contact, ...");
  ModelOptions options;
  options.kind =
      model.OneOf("kind", std::array{Kind{"auto", "auto"}, Kind{"bem2d", "bem2d"}}, kNow);
  options.elements = model.Integer("elements", 3, 4000, options.elements);
  model.OneOf("order", std::array{Order{"constant", 0}}, kNow);
  options.plane = model.OneOf("plane", std::array{PlaneChoice{"stress", Plane::kStress},
                                                  PlaneChoice{"strain", Plane::kStrain}});
  options.contact =
      model.OneOf("contact", std::array{Contact{"bonded", ContactLaw::kBonded},
                                        Contact{"frictionless", ContactLaw::kFrictionless}});
  options.tolerance = model.Number("tolerance", share, options.tolerance);
  options.rate = model.Number("rate", Positive(Dimension::kFrequency), options.rate);
  options.range = model.Number("range", share, 0.10);
  Section puncture = model.Open("puncture");
  options.puncture_depth = puncture.Number("depth", Positive(Dimension::kLength));
  return options;
}

}  // namespace palpate
