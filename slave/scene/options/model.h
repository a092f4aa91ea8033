// Model options of a scene. SI units.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace palpate {

enum class Plane : std::uint8_t { kStress, kStrain };
enum class ContactLaw : std::uint8_t { kBonded, kFrictionless, kFriction };
// Returns the text of model.contact.
constexpr std::string_view WordOf(ContactLaw law) {
  return law == ContactLaw::kBonded         ? "bonded"
         : law == ContactLaw::kFrictionless ? "frictionless"
                                            : "friction";
}
enum class ElementOrder : std::uint8_t { kConstant, kLinear, kQuadratic };
// One term of the Ogden model.
struct OgdenTerm {
  double share = 1;     // share of the initial shear modulus
  double exponent = 2;  // other than 0
};
// Options of `fem` and of the models derived from it (deploy/scenes/README.md, model).
struct FemOptions {
  enum class Element : std::uint8_t { kTet4, kTet10 } element = Element::kTet4;
  enum class Law : std::uint8_t {
    kCorotational,
    kLinear,
    kNeoHookean,
    kOgden
  } law = Law::kCorotational;
  bool is_law_default = false;   // the scene names none: it is DefaultLaw
  std::vector<OgdenTerm> terms;  // terms of kOgden; their shares add up to one
  enum class Time : std::uint8_t { kStatic, kDynamic } time = Time::kStatic;
  double step = 0.02;                  // time step [s]
  double residual = 1e-6;              // relative residual [-]
  Eigen::Vector3d gravity_O{0, 0, 0};  // [m/s^2]
};
// Whether this constitutive model is for large strains.
constexpr bool IsHyperelastic(FemOptions::Law law) {
  return law == FemOptions::Law::kNeoHookean || law == FemOptions::Law::kOgden;
}
// Law of a scene that names none. At rest it is for large strains: the corotational one is 12 % low
// at a tenth of the height (Poisson's ratio 0.45), 24 % at a fifth. In motion it is the one that
// the fast model computes.
constexpr FemOptions::Law DefaultLaw(FemOptions::Time time) {
  return time == FemOptions::Time::kStatic ? FemOptions::Law::kNeoHookean
                                           : FemOptions::Law::kCorotational;
}
struct ModelOptions {
  std::string kind = "auto";  // or one of kModelKinds
  int elements = 180;
  ElementOrder order = ElementOrder::kConstant;
  int modes = 0;  // number of modes of plate-large, which a study varies; 0: its default; no key
  FemOptions fem;
  std::filesystem::path cache;  // folder for Green's functions; empty: none are stored
  Plane plane = Plane::kStress;
  ContactLaw contact = ContactLaw::kBonded;
  double friction = 0;        // Coulomb's coefficient, with ContactLaw::kFriction [-]
  double deadline = 0;        // of an update [s]; 0: none
  double tolerance = 0.05;    // requested relative error of the force [-]
  double rate = 500;          // requested update rate [Hz]
  double range = 0;           // largest |displacement| / larger side that is not `extrapolated` [-]
  double puncture_depth = 0;  // overshoot that triggers the puncture cue [m]; 0: never
  double puncture_from = 0;   // depth from which the camera checks for a puncture [m]; 0: never
  double prestress = 0;       // tension of a membrane at rest [N/m]
  int refinements = 0;        // number of times each edge of a box or mesh file is halved
  std::string reason;         // why `kind: auto` took this model; empty: it was named
};

}  // namespace palpate
