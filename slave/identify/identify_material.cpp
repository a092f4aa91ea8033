#include "slave/identify/identify_material.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "shared/text/text.h"
#include "slave/identify/magnitude.h"
#include "slave/identify/specimen_spread.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/scene/scene_loader.h"
#include "slave/scene/units.h"

namespace palpate {
namespace {

using identify::TableRequest;

constexpr std::string_view kRelaxation = "relaxation", kPress = "press", kLoads = "loads",
                           kImages = "images";

// Parses KIND=FILE, KIND:RATIO=FILE, or FILE.
TableRequest ParseData(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos) return {{}, argument, 0};
  TableRequest request{argument.substr(0, equals), argument.substr(equals + 1), 0};
  const std::size_t colon = request.kind.find(':');
  if (colon == std::string::npos) return request;
  const auto ratio = ParseFinite(std::string_view(request.kind).substr(colon + 1));
  request.kind.resize(colon);
  if (!ratio || request.kind != "biaxial" || !(std::abs(*ratio) <= 10) || *ratio == 0) {
    throw std::invalid_argument(Shown(argument) +
                                ": expected biaxial:RATIO, the second strain by the first, for "
                                "example biaxial:0.5");
  }
  request.across = *ratio;
  return request;
}

std::optional<double> SizeOption(const char* option, const std::string& text, Dimension dimension) {
  if (text.empty()) return std::nullopt;
  constexpr double kMaxSize = 2;  // [m]; beyond, these are millimetres without a unit
  const auto value = ParseQuantity(text, dimension);
  if (!value || !(*value > 0 && *value <= kMaxSize)) {
    throw std::invalid_argument(std::string(option) + " = " + Shown(text) + ": expected " +
                                ExpectedQuantity(dimension, "above 0, up to 2 m"));
  }
  return value;
}

// `mm2`, `cm2` and `m2` behind a number, or a plain one in m^2.
std::optional<double> Area(const std::string& text) {
  if (text.empty()) return std::nullopt;
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"mm2", 1e-6}, {"cm2", 1e-4}, {"m2", 1}, {"", 1}};
  for (const auto& [unit, factor] : kUnits) {
    if (!text.ends_with(unit)) continue;
    const auto number =
        ParseFinite(Trimmed(std::string_view(text).substr(0, text.size() - unit.size())));
    constexpr double kMaxSize = 4;  // [m^2]
    if (number && *number > 0 && *number * factor <= kMaxSize) return *number * factor;
  }
  throw std::invalid_argument("--area = " + Shown(text) +
                              ": expected above 0, up to 4 m2, in m2 cm2 mm2");
}

identify::Specimen SpecimenOf(const IdentifyRequest& o) {
  if (o.ends != "free" && o.ends != "bonded") {
    throw std::invalid_argument("--ends = " + Shown(o.ends) + ": expected free or bonded");
  }
  if (!(o.from >= 0 && o.from < o.to)) {
    throw std::invalid_argument("--from, --to: expected 0 <= from < to, sizes of strain");
  }
  identify::Specimen specimen{.area = Area(o.area),
                              .height = SizeOption("--height", o.height, Dimension::kLength),
                              .diameter = SizeOption("--diameter", o.diameter, Dimension::kLength),
                              .bonded = o.ends == "bonded",
                              .poisson_ratio = o.poisson_ratio,
                              .abscissa = o.x,
                              .ordinate = o.y,
                              .from = o.from,
                              .to = o.to};
  if (!o.stress_unit.empty()) {
    specimen.stress_unit = ParseQuantity("1 " + o.stress_unit, Dimension::kPressure);
    if (!specimen.stress_unit) {
      throw std::invalid_argument("--stress-unit = " + Shown(o.stress_unit) +
                                  ": expected Pa, kPa, MPa, GPa or TPa");
    }
  }
  return specimen;
}

struct Requests {
  std::vector<TableRequest> tests, relaxations;
  std::filesystem::path press, loads, images;
};

Requests Sort(const IdentifyRequest& options) {
  Requests requests;
  for (const std::string& argument : options.data) {
    TableRequest request = ParseData(argument);
    if (request.kind == kRelaxation) {
      requests.relaxations.push_back(std::move(request));
    } else if (request.kind == kPress || request.kind == kLoads || request.kind == kImages) {
      auto& file = request.kind == kPress   ? requests.press
                   : request.kind == kLoads ? requests.loads
                                            : requests.images;
      if (!file.empty()) throw std::invalid_argument(request.kind + ": expected one file");
      file = request.file;
    } else {
      requests.tests.push_back(std::move(request));
    }
  }
  if (!(requests.press.empty() && requests.loads.empty()) && options.scene.empty()) {
    throw std::invalid_argument("press=FILE, loads=FILE: needs --scene with the object");
  }
  if (!requests.images.empty() && options.scene.empty()) {
    throw std::invalid_argument("images=FILE: needs --scene with the images of the contacts");
  }
  return requests;
}

// Reads a table whose numbers are possible; nullopt: it has too few rows and is left out.
template <class Table>
std::optional<Table> ReadOrLeaveOut(Table (*read)(const TableRequest&, const identify::Specimen&),
                                    const TableRequest& request, const identify::Specimen& specimen,
                                    IdentifyReport* report) {
  try {
    Table table = read(request, specimen);
    if (std::string remark = RequirePossible(table); !remark.empty()) {
      report->warnings.push_back(std::move(remark));
    }
    return table;
  } catch (const identify::TooFewRows& e) {
    report->warnings.push_back(std::string(e.what()) + "; left out");
    return std::nullopt;
  }
}

// The spread is that of the largest group of specimens that were tested in the same way.
void FindSpread(IdentifyReport* report) {
  std::array<std::vector<double>, 2> moduli;
  for (const NamedChord& named : report->moduli) {
    moduli[named.chord.compression ? 1 : 0].push_back(named.chord.modulus);
  }
  const auto& most = moduli[moduli[1].size() > moduli[0].size() ? 1 : 0];
  report->specimens = std::max<std::size_t>(1, most.size());
  report->specimen_sigma = identify::OtherSpecimenSigma(most);
}

void IdentifyLaws(const Requests& requests, const identify::Specimen& specimen, bool all_strains,
                  Progress* progress, IdentifyReport* report) {
  for (const TableRequest& request : requests.tests) {
    auto read = ReadOrLeaveOut(identify::ReadTest, request, specimen, report);
    if (!read) continue;
    const identify::MaterialTest& test = report->tests.emplace_back(std::move(*read));
    report->readings.push_back(ReadingOf(test));
    report->warnings.insert(report->warnings.end(), test.remarks.begin(), test.remarks.end());
    if (std::string warning = AgainstIsotropy(test); !warning.empty()) {
      report->warnings.push_back(std::move(warning));
    }
    const auto chord = ChordModulusOf(test);
    if (chord && chord->modulus > 2 * chord->sigma) {  // otherwise its interval includes zero
      report->moduli.push_back({test.name, *chord, test.end_factor});
    }
  }
  FindSpread(report);
  if (report->tests.empty()) return;
  ReportProgress(progress, "constitutive models", 0);
  identify::FitFromRest found = identify::FitLawsFromRest(report->tests, !all_strains);
  report->fitted_to = found.is_all ? 0 : found.largest_strain;
  report->tests = std::move(found.tests);
  report->fits = std::move(found.fits);
  report->dropped = std::move(found.dropped);
  for (const identify::LawFit& fit : report->fits) {
    report->shares.emplace_back();
    identify::RelativeRms(fit.law, report->tests, &report->shares.back());
  }
}

// The scene's modulus, a number with a unit, and the one that was found are of one material.
void CompareWithScene(const Scene& scene, const std::string& name, double found,
                      const char* units) {
  // Smallest factor that indicates another unit: kPa and psi differ by 7, Pa and kPa by 1000.
  constexpr double kTimes = 30;
  const double scenes = scene.object.material.young_modulus;
  if (found < kTimes * scenes && scenes < kTimes * found) return;
  throw InputError(
      Formatted("%s: Young's modulus %.3g Pa, that of the scene is %.3g Pa: Check the "
                "units: %s",
                name.c_str(), found, scenes, units));
}

void IdentifyRelaxation(const Requests& requests, const identify::Specimen& specimen,
                        IdentifyReport* report) {
  for (const TableRequest& request : requests.relaxations) {
    auto read = ReadOrLeaveOut(identify::ReadRelaxation, request, specimen, report);
    if (read) report->relaxations.push_back(std::move(*read));
  }
  if (report->relaxations.empty()) return;
  report->prony = identify::FitProny(report->relaxations);
}

// Identifies a modulus from presses or loads on the scene's object.
void IdentifyOnScene(const Requests& requests, const IdentifyRequest& options,
                     const IdentifyActions& actions, Progress* progress, IdentifyReport* report) {
  const Scene scene =
      WithChosenModel(LoadScene(options.scene, options.overrides, SceneUse::kSolve));
  if (actions.remark) actions.remark(scene);
  const auto note = [&](const std::filesystem::path& file, const PressFit& fit) {
    if (!fit.remark.empty()) report->warnings.push_back(file.string() + ": " + fit.remark);
    if (fit.extrapolated == 0) return;
    report->warnings.push_back(
        Formatted("%s: %d of %d cases are extrapolated, the first because %s", file.c_str(),
                  fit.extrapolated, fit.presses, std::string(fit.flag_reason).c_str()));
  };
  if (!requests.press.empty()) {
    report->press = FitPress(scene, requests.press, options.width, options.fit_poisson, progress);
    note(requests.press, *report->press);
    CompareWithScene(scene, requests.press.string(), report->press->young_modulus,
                     "those of the header, and object.material.young_modulus");
  }
  if (!requests.loads.empty()) {
    report->loads = FitLoads(scene, requests.loads, options.width, progress);
    note(requests.loads, *report->loads);
    CompareWithScene(
        scene, requests.loads.string(), report->loads->young_modulus,
        "those of the header, object.material.young_modulus and density, model.gravity");
  }
}

}  // namespace

std::vector<std::filesystem::path> InputFilesOf(const IdentifyRequest& request) {
  const Requests requests = Sort(request);
  std::vector<std::filesystem::path> inputs{requests.press, requests.loads, requests.images,
                                            request.scene};
  for (const TableRequest& table : requests.tests) inputs.push_back(table.file);
  for (const TableRequest& table : requests.relaxations) inputs.push_back(table.file);
  return inputs;
}

IdentifyReport Identify(const IdentifyRequest& request, const IdentifyActions& actions,
                        Progress* progress) {
  const Requests requests = Sort(request);
  if (!requests.images.empty() && !actions.fit_images) {
    throw std::invalid_argument("images=FILE: expected the command palpate-slave identify");
  }
  const identify::Specimen specimen = SpecimenOf(request);
  IdentifyReport report;
  IdentifyLaws(requests, specimen, request.to < kAllStrains, progress, &report);
  IdentifyRelaxation(requests, specimen, &report);
  if (!request.scene.empty() && !report.fits.empty()) {
    CompareWithScene(LoadScene(request.scene, request.overrides, SceneUse::kSolve),
                     report.tests.front().name, report.fits.front().law.YoungModulus(),
                     "those of the header, --stress-unit, --height, --diameter and --area");
  }
  const bool nothing = report.tests.empty() && report.relaxations.empty() &&
                       requests.press.empty() && requests.loads.empty() && requests.images.empty();
  if (nothing) {
    throw InputError(report.warnings.empty() ? "identify: no table" : report.warnings.front());
  }
  if (!requests.press.empty() || !requests.loads.empty()) {
    IdentifyOnScene(requests, request, actions, progress, &report);
  }
  if (!requests.images.empty()) {
    ReportProgress(progress, "images", 0);
    const Scene scene = WithChosenModel(LoadScene(request.scene, request.overrides));
    if (actions.remark) actions.remark(scene);
    report.images = actions.fit_images(scene, requests.images);
  }
  return report;
}

}  // namespace palpate
