// The results of `identify` and their output.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slave/identify/chord_modulus.h"
#include "slave/identify/law_fit.h"
#include "slave/identify/press_fit.h"
#include "slave/identify/prony.h"

namespace palpate {

// Young's modulus of a scene's object from recorded images of contacts.
struct ImageFit {
  double young_modulus = 0, sigma_modulus = 0;  // [Pa]
  double prestress = 0;  // prestress of the scene; for a dome proportional to the modulus [N/m]
  double offset = 0, sigma_offset = 0;  // of the measured forces [N]
  double rms = 0;                       // of the forces, over the largest [-]
  // Number of samples with a known, valid force; number with a force other than zero.
  int samples = 0, pressed = 0;
  int passes = 0;  // number of passes through the images
};

struct NamedChord {
  std::string name;
  identify::ChordModulus chord;
  double end_factor = 1;
};

struct IdentifyReport {
  std::vector<identify::MaterialTest> tests;  // rows that were fitted
  double fitted_to = 0;                       // largest strain of these rows [-]; 0: all
  std::vector<std::string> warnings;          // of the tables, a sentence each
  // For each table how it was interpreted, for a person to check.
  std::vector<std::string> readings;
  std::vector<NamedChord> moduli;
  std::vector<identify::LawFit> fits;       // the best first
  std::vector<std::vector<double>> shares;  // rms of each test over its peak, per fit
  std::vector<std::string> dropped;         // models with a constant whose interval includes zero
  // Relative standard deviation of the modulus of another specimen, from this number of them.
  double specimen_sigma = 0;
  std::size_t specimens = 1;
  std::vector<identify::RelaxationTable> relaxations;
  std::optional<identify::PronyFit> prony;
  std::optional<PressFit> press, loads;
  std::optional<ImageFit> images;
};

// Lines of a scene for a fit; empty: `model` does not accept this constitutive model, it is
// unstable, or off at rest. `specimen_sigma`: as in the report.
std::string SceneLines(const identify::LawFit& fit, double specimen_sigma);

// Returns for example "comp: read as a compression of up to 25 %, where the specimen bears 54 N,
// the weight of 5500 g. Otherwise a unit or a size is wrong"; if the section is unknown, the load
// is that of 10 mm x 10 mm.
std::string ReadingOf(const identify::MaterialTest& test);

std::string ToWords(const IdentifyReport& report);
// Returns the content of report.json.
std::string ToJson(const IdentifyReport& report);

}  // namespace palpate
