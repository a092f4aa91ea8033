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
    kOgden  // mooney-rivlin and ogden
  } law = Law::kCorotational;
  std::vector<OgdenTerm> terms;  // terms of kOgden; their shares add up to one
  enum class Time : std::uint8_t { kStatic, kDynamic } time = Time::kStatic;
  double step = 0.02;                  // time step [s]
  double damping_mass = 0;             // Rayleigh damping a [1/s]
  double damping_stiffness = 0;        // Rayleigh damping b [s]
  double residual = 1e-6;              // relative residual [-]
  Eigen::Vector3d gravity_O{0, 0, 0};  // [m/s^2]
  int threads = 1;                     // threads of the assembly; they do not change the result
};
// Whether this constitutive model is for large strains.
constexpr bool IsHyperelastic(FemOptions::Law law) {
  return law == FemOptions::Law::kNeoHookean || law == FemOptions::Law::kOgden;
}
// A model that `kind: auto` rejected. NaN: unknown.
struct RejectedModel {
  std::string model;      // kind, variant and resolution
  std::string why;        // reason for the rejection
  double error = 0;       // error of the contact force, relative [-]
  double update = 0;      // 99th percentile of the update time [s]
  double precompute = 0;  // precompute time [s]
};
// The decision of `kind: auto`. An empty reason means that there is none.
struct ModelDecision {
  std::string reason;  // one sentence: the model, the reason and its figures
  bool meets = false;  // whether it meets tolerance and rate within the model's range
  double error = 0;    // error of the contact force, relative [-]
  std::vector<RejectedModel> rejected;  // nearest first
  double bound = 0;                     // of the error at nine of ten of all places [-]
  double update = 0;                    // slowest percent of the updates [s]
};

// Statement about a model's accuracy in `check`, `auto`, `study` and the scene's description.
enum class Promise : std::uint8_t { kMeets, kMayMiss, kMisses };
// kMayMiss: the error is within the tolerance, its bound is not.
Promise OnTolerance(double error, double bound, double tolerance) noexcept;
// The promise of an update [s] at a rate [Hz].
Promise OnRate(double update, double rate) noexcept;
const char* ToString(Promise promise);  // "meets", "may miss", "MISSES"

struct ModelOptions {
  std::string kind = "auto";  // or one of kModelKinds
  int elements = 180;
  ElementOrder order = ElementOrder::kConstant;
  int modes = 0;  // number of modes of plate-large; 0: its default
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
  ModelDecision decision;     // set if the kind above was `auto`
};

}  // namespace palpate
