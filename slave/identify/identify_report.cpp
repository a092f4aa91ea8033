#include "slave/identify/identify_report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "shared/text/text.h"
#include "slave/identify/specimen_spread.h"
#include "slave/program/plain_modulus.h"

namespace palpate {
namespace {

using identify::LawFit;
using Json = nlohmann::ordered_json;

// Residual relative to the peak above which a fit gives a warning [-].
constexpr double kPoorFit = 0.1;
constexpr double kMinShare = 1e-12;         // of a term in a scene
constexpr double kPoissonOfScene = 0.4999;  // `model` solves this with a pressure unknown
constexpr const char* kDefinition =
    "slope of nominal stress between 10 and 20 % strain, divided by the stiffening due to bonded "
    "ends";

double SigmaOf(const LawFit& fit, Eigen::Index i) {
  return std::sqrt(std::max(0.0, fit.covariance(i, i)));
}

// Half width of the 95 % interval of another specimen's modulus [Pa].
double HalfWidth(double modulus, double sigma, double specimen_sigma) {
  return identify::kSpecimenWide * std::hypot(sigma, specimen_sigma * modulus);
}

std::string MaterialLine(double young_modulus, double poisson_ratio, double sigma) {
  return fmt::format(
      "  object.material: {{young_modulus: {:.6g} Pa, poisson_ratio: {:.4g}, tolerance: {:.2g}}}\n",
      young_modulus, poisson_ratio, std::min(sigma, 1.0));
}
constexpr const char* kLinearModel = "  model: {kind: fem, element: tet10}\n";

Json ToJson(const NamedChord& named, double specimen_sigma) {
  const identify::ChordModulus& c = named.chord;
  return {{"test", named.name},
          {"definition", kDefinition},
          {"modulus_Pa", c.modulus},
          {"sigma_Pa", c.sigma},
          {"half_width_Pa", HalfWidth(c.modulus, c.sigma, specimen_sigma)},
          {"linear_model_excess", c.excess},
          {"from", c.from},
          {"to", c.to},
          {"end_factor", named.end_factor}};
}

Json ConstantsOf(const LawFit& fit) {
  Json constants = Json::array();
  for (Eigen::Index i = 0; i < fit.values.size(); ++i) {
    const double sigma = SigmaOf(fit, i);
    constants.push_back({{"name", fit.names[static_cast<std::size_t>(i)]},
                         {"value", fit.values[i]},
                         {"sigma", sigma},
                         {"low", fit.values[i] - identify::kNormalWide * sigma},
                         {"high", fit.values[i] + identify::kNormalWide * sigma}});
  }
  return constants;
}

Json ToJson(const LawFit& fit, const std::vector<double>& shares, const IdentifyReport& report) {
  Json per_test = Json::object();
  for (std::size_t i = 0; i < report.tests.size(); ++i) per_test[report.tests[i].name] = shares[i];
  const double E = fit.law.YoungModulus();
  return {{"law", fit.law.name},
          {"constants", ConstantsOf(fit)},
          {"shear_modulus_Pa", fit.law.ShearModulus()},
          {"young_modulus_Pa", E},
          {"half_width_Pa", HalfWidth(E, fit.young_sigma, report.specimen_sigma)},
          {"rms_of_peak", fit.rms},
          {"rms_of_own_peak", per_test},
          {"off_at_rest", fit.at_rest.off},
          {"bic", fit.bic},
          {"stable", fit.unstable.empty()},
          {"instability", fit.unstable},
          {"scene", SceneLines(fit, report.specimen_sigma)}};
}

// Young's modulus of a Prony series after the longest record and at the beginning.
struct Faded {
  double held = 0, at_once = 0;  // [Pa]
  double half_width = 0;         // half width of the 95 % interval of `held` [Pa]
  double record = 0;             // [s]
  std::string scene;
  std::string relaxing_scene;  // scene with the series; empty: the modulus fades to zero
};

// Returns the scene's lines of a body that relaxes. Poisson's ratio is the largest for which
// `fem-green` is not extrapolated.
std::string RelaxingLines(const identify::PronyFit& prony, bool shear, double sigma) {
  constexpr double kPoisson = 0.48;
  const bool fits = prony.equilibrium > 0 && !prony.terms.empty() &&
                    prony.terms.size() <= Material::kMaxRelaxationTerms;
  if (!fits) return {};
  std::string terms;
  for (const identify::PronyTerm& term : prony.terms) {
    terms += fmt::format("{}{{share: {:.6g}, time: {:.6g} s}}", terms.empty() ? "" : ", ",
                         term.modulus / prony.instant, term.time);
  }
  return fmt::format(
      "  object.material: {{young_modulus: {:.6g} Pa, poisson_ratio: {:.4g}, tolerance: {:.2g}, "
      "relaxation: [{}]}}\n  model: {{kind: fem-green}}\n",
      (shear ? 2 * (1 + kPoisson) : 1) * prony.instant, kPoisson, std::min(sigma, 1.0), terms);
}

Faded FadedOf(const IdentifyReport& report) {
  Faded faded;
  for (const identify::RelaxationTable& table : report.relaxations) {
    faded.record = std::max(faded.record, table.time.back() - table.time.front());
  }
  const double by = report.relaxations.front().shear ? 2 * (1 + kPoissonOfScene) : 1;
  faded.held = by * report.prony->At(faded.record), faded.at_once = by * report.prony->instant;
  const double own = by * report.prony->sigma;
  faded.half_width = HalfWidth(faded.held, own, report.specimen_sigma);
  const double sigma = std::hypot(report.specimen_sigma, own / faded.held);
  faded.scene = MaterialLine(faded.held, kPoissonOfScene, sigma) + kLinearModel;
  faded.relaxing_scene = RelaxingLines(*report.prony, report.relaxations.front().shear, sigma);
  return faded;
}

Json ToJson(const identify::PronyFit& prony, const Faded& faded) {
  Json terms = Json::array();
  for (const identify::PronyTerm& term : prony.terms) {
    terms.push_back(
        {{"modulus_Pa", term.modulus}, {"sigma_Pa", term.sigma}, {"time_s", term.time}});
  }
  return {{"instant_Pa", prony.instant},
          {"equilibrium_Pa", prony.equilibrium},
          {"sigma_Pa", prony.sigma},
          {"terms", terms},
          {"rms_of_peak", prony.rms},
          {"young_modulus_held_Pa", faded.held},
          {"half_width_Pa", faded.half_width},
          {"young_modulus_at_once_Pa", faded.at_once},
          {"scene", faded.scene},
          {"relaxing_scene", faded.relaxing_scene}};
}

Json ToJson(const PressFit& press) {
  return {{"young_modulus_Pa", press.young_modulus},
          {"sigma_Pa", press.sigma_modulus},
          {"poisson_ratio", press.poisson_ratio},
          {"poisson_sought", press.sought_poisson},
          {"sigma_poisson", press.sigma_poisson},
          {"rms_of_peak", press.rms},
          {"presses", press.presses},
          {"alone_Pa", Json(press.alone)},
          {"model", press.kind}};
}

Json ToJson(const ImageFit& images) {
  return {{"young_modulus_Pa", images.young_modulus},
          {"sigma_Pa", images.sigma_modulus},
          {"prestress_N_per_m", images.prestress},
          {"offset_N", images.offset},
          {"sigma_offset_N", images.sigma_offset},
          {"rms_of_peak", images.rms},
          {"samples", images.samples},
          {"pressed", images.pressed},
          {"passes", images.passes}};
}

std::string ToWords(const PressFit& fit, const char* cases, const char* quantity) {
  std::string words = fmt::format(
      "{} {} with {}: E {:.5g} +- {:.2g} Pa, nu {:.4g}, rms {:.3g} % of the largest {}\n  "
      "object.material: {{young_modulus: {:.6g} Pa, poisson_ratio: {:.4g}}}\n",
      fit.presses, cases, fit.kind, fit.young_modulus, identify::kNormalWide * fit.sigma_modulus,
      fit.poisson_ratio, 100 * fit.rms, quantity, fit.young_modulus, fit.poisson_ratio);
  words += "  " + ModulusText(fit.young_modulus) + "\n";
  for (const auto& [name, modulus] : fit.alone) {
    words += fmt::format("  {} alone: E {:.5g} Pa\n", name, modulus);
  }
  return words;
}

std::string ToWords(const ImageFit& fit) {
  std::string words = fmt::format(
      "{} samples with a known force, {} of them in contact: E {:.5g} +- {:.2g} Pa, force offset "
      "{:.3g} +- {:.2g} N, rms {:.3g} % of the largest force\n  object.material.young_modulus: "
      "{:.6g} Pa\n",
      fit.samples, fit.pressed, fit.young_modulus, identify::kNormalWide * fit.sigma_modulus,
      fit.offset, identify::kNormalWide * fit.sigma_offset, 100 * fit.rms, fit.young_modulus);
  words += "  " + ModulusText(fit.young_modulus) + "\n";
  if (fit.prestress > 0) words += fmt::format("  model.prestress: {:.4g} N/m\n", fit.prestress);
  return words;
}

bool IsRefused(const LawFit& fit) {
  return fit.at_rest.excess() > identify::kMaxOffAtRest;
}

std::string WordsOf(const LawFit& fit) {
  std::string words;
  for (Eigen::Index i = 0; i < fit.values.size(); ++i) {
    words += fmt::format(" {} {:.4g} +- {:.2g}", fit.names[static_cast<std::size_t>(i)],
                         fit.values[i], identify::kNormalWide * SigmaOf(fit, i));
  }
  return words;
}

// Returns the first fit whose law a scene can have, or null.
const LawFit* ReadByScenes(const IdentifyReport& report) {
  const auto found = std::ranges::find_if(
      report.fits, [](const LawFit& fit) { return !SceneLines(fit, 0).empty(); });
  return found == report.fits.end() ? nullptr : &*found;
}

void AddScene(const IdentifyReport& report, std::string* words) {
  const LawFit& best = report.fits.front();
  const LawFit* fit = ReadByScenes(report);
  if (fit == nullptr) return;
  if (fit != &best) {
    *words += fmt::format(
        "  no scene reads {}; the best that it reads is {}, rms {:.2f} % instead of {:.2f} %\n",
        best.law.name, fit->law.name, 100 * fit->rms, 100 * best.rms);
  }
  const double E = fit->law.YoungModulus();
  const auto [low, high] = identify::LinearRange(fit->law);
  *words += SceneLines(*fit, report.specimen_sigma);
  *words += fmt::format(
      "  E at rest {:.4g} +- {:.2g} Pa: for object.material.young_modulus with this model, or\n"
      "  for a linear model, which is within 10 % of {} from {:.1f} to {:.1f} % strain\n",
      E, HalfWidth(E, fit->young_sigma, report.specimen_sigma), fit->law.name, 100 * low,
      100 * high);
  if (fit->at_rest.excess() > identify::kOffAtRest) {
    *words += fmt::format(
        "  warning: at rest the measured stress is {:+.0f} % off this model; +- includes it\n",
        100 * fit->at_rest.off);
  }
  if (fit->rms > kPoorFit) *words += "  warning: these lines are of a fit worse than 10 %\n";
}

void AddLaws(const IdentifyReport& report, std::string* words) {
  for (const LawFit& fit : report.fits) {
    *words += fmt::format("  {:<14} rms {:6.2f} % of the peak{}{}\n", fit.law.name, 100 * fit.rms,
                          WordsOf(fit), fit.unstable.empty() ? "" : "  UNSTABLE: " + fit.unstable);
  }
  if (!report.dropped.empty()) {
    *words += fmt::format("  left out, the interval includes zero: {}\n",
                          fmt::join(report.dropped, ", "));
  }
  const LawFit& best = report.fits.front();
  if (!best.unstable.empty()) {
    *words += "no stable constitutive model was found: none is proposed\n";
    return;
  }
  if (report.fitted_to > 0) {
    *words += fmt::format(
        "fitted up to {:.0f} % strain: over more, no model also holds at rest; --to fits more\n",
        100 * report.fitted_to);
  }
  if (IsRefused(best)) {
    *words += fmt::format(
        "refused: at rest the measured stress is {:+.0f} % off {}: none is proposed; give a test "
        "with more rows at small strain, or --to\n",
        100 * best.at_rest.off, best.law.name);
    return;
  }
  const double E = best.law.YoungModulus();
  *words += fmt::format(
      "{}: {}; at rest E {:.4g} +- {:.2g} Pa\n",
      best.rms > kPoorFit
          ? fmt::format("warning: no model fits within {:.0f} %; closest (rms {:.1f} %)",
                        100 * kPoorFit, 100 * best.rms)
          : "best",
      best.law.name, E, HalfWidth(E, best.young_sigma, report.specimen_sigma));
  *words += "  " + ModulusText(E) + "\n";
  AddScene(report, words);
}

void AddModuli(const IdentifyReport& report, std::string* words) {
  for (const NamedChord& named : report.moduli) {
    const identify::ChordModulus& c = named.chord;
    *words += fmt::format(
        "{}: chord modulus {:.4g} +- {:.2g} Pa ({:.0f} to {:.0f} %; ends x {:.3f})\n"
        "  for object.material.young_modulus of a linear model pressed so far; at {:.0f} % its "
        "force "
        "is {:+.0f} % off\n",
        named.name, c.modulus, HalfWidth(c.modulus, c.sigma, report.specimen_sigma), 100 * c.from,
        100 * c.to, named.end_factor, 100 * c.to, 100 * c.excess);
  }
  if (report.moduli.empty() && report.fits.empty()) return;
  *words += fmt::format(
      "+- of a modulus: 95 % for another specimen; {} here, standard deviation {:.1f} %\n",
      report.specimens, 100 * report.specimen_sigma);
}

void AddRelaxation(const IdentifyReport& report, std::string* words) {
  const identify::PronyFit& prony = *report.prony;
  *words += fmt::format(
      "{}relaxation: instantaneous modulus {:.4g} Pa, long-term modulus {:.4g} Pa, rms {:.2f} % of "
      "the peak\n",
      prony.rms > kPoorFit ? "warning: no Prony series fits within 10 %; " : "", prony.instant,
      prony.equilibrium, 100 * prony.rms);
  for (const identify::PronyTerm& term : prony.terms) {
    *words += fmt::format("  {:.4g} +- {:.2g} Pa in {:.3g} s\n", term.modulus,
                          identify::kNormalWide * term.sigma, term.time);
  }
  if (prony.dropped > 0) {
    *words += fmt::format("  left out, the interval includes zero: {} terms\n", prony.dropped);
  }
  const Faded faded = FadedOf(report);
  *words += faded.scene;
  *words += fmt::format(
      "  object.material.young_modulus {:.4g} +- {:.2g} Pa (95 %, another specimen) is for "
      "contacts "
      "held for {:.3g} s, {:.4g} Pa for quick ones\n",
      faded.held, faded.half_width, faded.record, faded.at_once);
  if (!faded.relaxing_scene.empty()) {
    *words += "  or, with relaxation, at small strains:\n" + faded.relaxing_scene;
  }
}

}  // namespace

std::string SceneLines(const LawFit& fit, double specimen_sigma) {
  if (!fit.unstable.empty() || fit.law.terms.empty() || IsRefused(fit)) return {};
  const double G = fit.law.ShearModulus();
  const double sigma = std::hypot(specimen_sigma, fit.young_sigma / fit.law.YoungModulus());
  std::string terms;
  for (const identify::LawTerm& term : fit.law.terms) {
    if (term.G < kMinShare * G) continue;
    terms += fmt::format("{}[{:.6g}, {:.6g}]", terms.empty() ? "" : ", ", term.G / G, term.alpha);
  }
  return MaterialLine(2 * (1 + kPoissonOfScene) * G, kPoissonOfScene, sigma) +
         fmt::format("  model: {{kind: fem, law: ogden, terms: [{}], element: tet10}}\n", terms);
}

std::string ReadingOf(const identify::MaterialTest& test) {
  constexpr double kSquare = 1e-4;  // [m^2]
  const auto row = std::ranges::max_element(
      test.rows, {}, [&](const identify::TestRow& r) { return identify::LargestStrain(test, r); });
  const double strain = identify::LargestStrain(test, *row);
  const bool is_compression = test.kind == identify::TestKind::kUniaxial && row->abscissa < 1;
  const char* kind = test.kind == identify::TestKind::kShear ? "shear"
                     : is_compression                        ? "compression"
                                                             : "strain";
  return fmt::format(
      "{}: read as a {} of up to {:.3g} %, where {} bears {}. If that is not so, a unit or a size "
      "is wrong",
      test.name, kind, 100 * strain, test.area > 0 ? "the specimen" : "a square of 10 mm",
      ForceText(std::abs(row->measured.front()) * (test.area > 0 ? test.area : kSquare)));
}

std::string ToWords(const IdentifyReport& report) {
  std::string words;
  for (const std::string& reading : report.readings) words += reading + "\n";
  for (const std::string& warning : report.warnings) words += warning + "\n";
  AddModuli(report, &words);
  if (!report.fits.empty()) AddLaws(report, &words);
  if (report.prony) AddRelaxation(report, &words);
  if (report.press) words += ToWords(*report.press, "contacts", "force");
  if (report.loads) words += ToWords(*report.loads, "cases under loads", "displacement");
  if (report.images) words += ToWords(*report.images);
  return words;
}

std::string ToJson(const IdentifyReport& report) {
  Json json = {{"warnings", report.warnings}, {"moduli", Json::array()}, {"laws", Json::array()}};
  for (const NamedChord& named : report.moduli) {
    json["moduli"].push_back(ToJson(named, report.specimen_sigma));
  }
  for (std::size_t i = 0; i < report.fits.size(); ++i) {
    json["laws"].push_back(ToJson(report.fits[i], report.shares[i], report));
  }
  if (report.fitted_to > 0) json["fitted_to"] = report.fitted_to;
  if (!report.fits.empty() && report.fits.front().unstable.empty() &&
      !IsRefused(report.fits.front())) {
    json[report.fits.front().rms > kPoorFit ? "closest" : "best"] = report.fits.front().law.name;
  }
  if (const LawFit* fit = ReadByScenes(report)) json["scene_law"] = fit->law.name;
  json["dropped"] = report.dropped;
  json["specimens"] = {{"count", report.specimens}, {"sigma", report.specimen_sigma}};
  if (report.prony) json["relaxation"] = ToJson(*report.prony, FadedOf(report));
  if (report.press) json["press"] = ToJson(*report.press);
  if (report.loads) json["loads"] = ToJson(*report.loads);
  if (report.images) json["images"] = ToJson(*report.images);
  return json.dump(2) + "\n";
}

}  // namespace palpate
