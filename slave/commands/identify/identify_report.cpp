#include "slave/commands/identify/identify_report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using identify::LawFit;
using Json = nlohmann::ordered_json;

constexpr double kWide = 1.96;
constexpr double kLeastShare = 1e-12;       // of a term in a scene
constexpr double kPoissonOfScene = 0.4999;  // what `model` solves with a pressure of its own
constexpr const char* kDefinition =
    "slope of nominal stress between 10 and 20 % strain, divided by the stiffening due to bonded "
    "ends";

double SigmaOf(const LawFit& fit, Eigen::Index i) {
  return std::sqrt(std::max(0.0, fit.covariance(i, i)));
}

Json ToJson(const NamedChord& named) {
  const identify::ChordModulus& c = named.chord;
  return {{"test", named.name},
          {"definition", kDefinition},
          {"modulus_Pa", c.modulus},
          {"sigma_Pa", c.sigma},
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
                         {"low", fit.values[i] - kWide * sigma},
                         {"high", fit.values[i] + kWide * sigma}});
  }
  return constants;
}

Json ToJson(const LawFit& fit, const std::vector<double>& shares,
            const std::vector<identify::MaterialTest>& tests) {
  Json per_test = Json::object();
  for (std::size_t i = 0; i < tests.size(); ++i) per_test[tests[i].name] = shares[i];
  return {{"law", fit.law.name},
          {"constants", ConstantsOf(fit)},
          {"shear_modulus_Pa", fit.law.ShearModulus()},
          {"young_modulus_Pa", fit.law.YoungModulus()},
          {"poisson_ratio", fit.law.PoissonRatio()},
          {"rms_of_peak", fit.rms},
          {"rms_of_own_peak", per_test},
          {"bic", fit.bic},
          {"stable", fit.unstable.empty()},
          {"instability", fit.unstable},
          {"not_told", fit.untold},
          {"would_tell", fit.extra},
          {"scene", SceneLines(fit)}};
}

Json ToJson(const identify::PronyFit& prony) {
  Json terms = Json::array();
  for (const identify::PronyTerm& term : prony.terms) {
    terms.push_back(
        {{"modulus_Pa", term.modulus}, {"sigma_Pa", term.sigma}, {"time_s", term.time}});
  }
  return {{"instant_Pa", prony.instant},
          {"equilibrium_Pa", prony.equilibrium},
          {"sigma_Pa", prony.sigma},
          {"terms", terms},
          {"rms_of_peak", prony.rms}};
}

Json ToJson(const PressFit& press) {
  return {{"young_modulus_Pa", press.young_modulus},
          {"sigma_Pa", press.sigma_modulus},
          {"poisson_ratio", press.poisson_ratio},
          {"poisson_sought", press.sought_poisson},
          {"sigma_poisson", press.sigma_poisson},
          {"rms_of_peak", press.rms},
          {"presses", press.presses},
          {"model", press.kind}};
}

Json ToJson(const PictureFit& pictures) {
  return {{"young_modulus_Pa", pictures.young_modulus},
          {"sigma_Pa", pictures.sigma_modulus},
          {"prestress_N_per_m", pictures.prestress},
          {"offset_N", pictures.offset},
          {"sigma_offset_N", pictures.sigma_offset},
          {"rms_of_peak", pictures.rms},
          {"samples", pictures.samples},
          {"pressed", pictures.pressed},
          {"passes", pictures.passes}};
}

std::string ToWords(const PictureFit& fit) {
  std::string words = fmt::format(
      "{} samples with a known force, {} of them in contact: E {:.5g} +- {:.2g} Pa, force offset "
      "{:.3g} +- {:.2g} N, rms {:.3g} % of the largest force\n  object.material.young_modulus: "
      "{:.6g} Pa\n",
      fit.samples, fit.pressed, fit.young_modulus, kWide * fit.sigma_modulus, fit.offset,
      kWide * fit.sigma_offset, 100 * fit.rms, fit.young_modulus);
  if (fit.prestress > 0) words += fmt::format("  model.prestress: {:.4g} N/m\n", fit.prestress);
  return words;
}

void WritePredictions(const IdentifyReport& report, const std::filesystem::path& file) {
  std::string text = "test,abscissa,nominal_stress_Pa,low_Pa,high_Pa\n";
  for (const identify::PredictedCurve& curve : report.predictions) {
    for (const identify::PredictedRow& row : curve.rows) {
      text += curve.name;
      for (const double value : {row.abscissa, row.stress, row.low, row.high}) {
        text += ',';
        AppendNumber(&text, value, 9);
      }
      text += '\n';
    }
  }
  WriteWholeFile(file, text);
}

std::string WordsOf(const LawFit& fit) {
  std::string words;
  for (Eigen::Index i = 0; i < fit.values.size(); ++i) {
    words += fmt::format(" {} {:.4g} +- {:.2g}", fit.names[static_cast<std::size_t>(i)],
                         fit.values[i], kWide * SigmaOf(fit, i));
  }
  return words;
}

void AddLaws(const IdentifyReport& report, std::string* words) {
  for (const LawFit& fit : report.fits) {
    *words += fmt::format("  {:<14} rms {:6.2f} % of the peak{}{}\n", fit.law.name, 100 * fit.rms,
                          WordsOf(fit), fit.unstable.empty() ? "" : "  UNSTABLE: " + fit.unstable);
  }
  const LawFit& best = report.fits.front();
  if (!best.unstable.empty()) {
    *words += "no stable constitutive model was found: none is proposed\n";
    return;
  }
  *words += fmt::format("best: {}; at rest E {:.4g} Pa, nu {:.4g}\n", best.law.name,
                        best.law.YoungModulus(), best.law.PoissonRatio());
  if (!best.untold.empty()) {
    *words += fmt::format("  these data determine poorly: {}; a test that determines it: {}\n",
                          best.untold, best.extra);
  }
  if (const std::string lines = SceneLines(best); !lines.empty()) *words += lines;
}

}  // namespace

std::string SceneLines(const LawFit& fit) {
  if (!fit.unstable.empty() || fit.law.nu || fit.law.terms.empty()) return {};
  const double G = fit.law.ShearModulus();
  std::string terms;
  for (const identify::LawTerm& term : fit.law.terms) {
    if (term.G < kLeastShare * G) continue;
    terms += fmt::format("{}[{:.6g}, {:.6g}]", terms.empty() ? "" : ", ", term.G / G, term.alpha);
  }
  return fmt::format(
      "  object.material: {{young_modulus: {:.6g} Pa, poisson_ratio: {}}}\n"
      "  model: {{kind: fem-hyperelastic, law: ogden, terms: [{}], element: tet10}}\n",
      2 * (1 + kPoissonOfScene) * G, kPoissonOfScene, terms);
}

std::string ToWords(const IdentifyReport& report) {
  std::string words;
  for (const std::string& doubt : report.doubts) words += doubt + "\n";
  for (const NamedChord& named : report.moduli) {
    words +=
        fmt::format("{}: chord modulus {:.4g} +- {:.2g} Pa ({:.0f} to {:.0f} %; ends x {:.3f})\n",
                    named.name, named.chord.modulus, kWide * named.chord.sigma,
                    100 * named.chord.from, 100 * named.chord.to, named.end_factor);
  }
  if (!report.fits.empty()) AddLaws(report, &words);
  if (report.prony) {
    words += fmt::format(
        "relaxation: instantaneous modulus {:.4g} Pa, long-term modulus {:.4g} Pa, rms {:.2f} % of "
        "the peak\n",
        report.prony->instant, report.prony->equilibrium, 100 * report.prony->rms);
    for (const identify::PronyTerm& term : report.prony->terms) {
      words += fmt::format("  {:.4g} +- {:.2g} Pa in {:.3g} s\n", term.modulus, kWide * term.sigma,
                           term.time);
    }
  }
  if (report.press) {
    words += fmt::format(
        "{} contacts with {}: E {:.5g} +- {:.2g} Pa, nu {:.4g}, rms {:.3g} % of the largest "
        "force\n  object.material: {{young_modulus: {:.6g} Pa, poisson_ratio: {:.4g}}}\n",
        report.press->presses, report.press->kind, report.press->young_modulus,
        kWide * report.press->sigma_modulus, report.press->poisson_ratio, 100 * report.press->rms,
        report.press->young_modulus, report.press->poisson_ratio);
  }
  if (report.pictures) words += ToWords(*report.pictures);
  return words;
}

void WriteReport(const IdentifyReport& report, const std::filesystem::path& out) {
  Json json = {{"doubts", report.doubts}, {"moduli", Json::array()}, {"laws", Json::array()}};
  for (const NamedChord& named : report.moduli) json["moduli"].push_back(ToJson(named));
  for (std::size_t i = 0; i < report.fits.size(); ++i) {
    json["laws"].push_back(ToJson(report.fits[i], report.shares[i], report.tests));
  }
  if (!report.fits.empty() && report.fits.front().unstable.empty()) {
    json["best"] = report.fits.front().law.name;
  }
  if (!report.predicted_by.empty()) json["predicted_by"] = report.predicted_by;
  if (report.prony) json["relaxation"] = ToJson(*report.prony);
  if (report.press) json["press"] = ToJson(*report.press);
  if (report.pictures) json["pictures"] = ToJson(*report.pictures);
  WriteWholeFile(out / "report.json", json.dump(2) + "\n");
  WriteWholeFile(out / "identify.svg", DrawIdentify(report));
  if (!report.predictions.empty()) WritePredictions(report, out / "predictions.csv");
}

}  // namespace palpate
