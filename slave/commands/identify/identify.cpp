#include "slave/commands/identify/identify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"
#include "slave/commands/identify/identify_report.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/scene_remarks.h"
#include "slave/identify/magnitude.h"
#include "slave/identify/specimen_spread.h"
#include "slave/scene/scene_loader.h"
#include "slave/scene/units.h"

namespace palpate {
namespace {

using identify::TableRequest;

constexpr std::string_view kRelaxation = "relaxation", kPress = "press", kLoads = "loads",
                           kPictures = "pictures";

// KIND=FILE, KIND:RATIO=FILE, or FILE alone.
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
  constexpr double kLargest = 2;  // [m]; beyond, these are millimetres without a unit
  const auto value = ParseQuantity(text, dimension);
  if (!value || !(*value > 0 && *value <= kLargest)) {
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
    constexpr double kLargest = 4;  // [m^2]
    if (number && *number > 0 && *number * factor <= kLargest) return *number * factor;
  }
  throw std::invalid_argument("--area = " + Shown(text) +
                              ": expected above 0, up to 4 m2, in m2 cm2 mm2");
}

identify::Specimen SpecimenOf(const IdentifyOptions& o) {
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
  std::filesystem::path press, loads, pictures;
};

Requests Sort(const IdentifyOptions& options) {
  Requests requests;
  for (const std::string& argument : options.data) {
    TableRequest request = ParseData(argument);
    if (request.kind == kRelaxation) {
      requests.relaxations.push_back(std::move(request));
    } else if (request.kind == kPress || request.kind == kLoads || request.kind == kPictures) {
      auto& file = request.kind == kPress   ? requests.press
                   : request.kind == kLoads ? requests.loads
                                            : requests.pictures;
      if (!file.empty()) throw std::invalid_argument(request.kind + ": expected one file");
      file = request.file;
    } else {
      requests.tests.push_back(std::move(request));
    }
  }
  if (!(requests.press.empty() && requests.loads.empty()) && options.scene.empty()) {
    throw std::invalid_argument("press=FILE, loads=FILE: needs --scene with the object");
  }
  if (!requests.pictures.empty() && options.scene.empty()) {
    throw std::invalid_argument("pictures=FILE: needs --scene with the images of the contacts");
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

// The largest number of specimens that were tested the same way decides their spread.
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
    if (chord && chord->modulus > 2 * chord->sigma) {  // else its interval includes zero
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
  constexpr double kTimes = 30;  // of another unit: from kPa to psi 7, from Pa to kPa 1000
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

// From presses or loads on the scene's object.
void IdentifyOnScene(const Requests& requests, const IdentifyOptions& options, Progress* progress,
                     IdentifyReport* report) {
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  LogRemarks(scene);
  const auto note = [&](const std::filesystem::path& file, const PressFit& fit) {
    if (fit.extrapolated == 0) return;
    report->warnings.push_back(Formatted("%s: %d of %d cases are beyond the model's range",
                                         file.c_str(), fit.extrapolated, fit.presses));
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

const char* const kIdentifyHelp = R"(DATA is KIND=FILE.csv, where KIND is
  uniaxial, tension, compression   stress (or force) against stretch, strain or displacement
  equibiaxial, planar              the same columns; planar: the second direction is fixed
  biaxial, biaxial:RATIO           column stretch_2, or second strain = RATIO x first strain
  shear                            stress against amount of shear
  relaxation                       time, strain or shear, stress; gives a Prony series
  press                            case,x,y,z,dx,dy,dz,fx,fy,fz as `solve` writes them; gives E
  loads                            case,x,y,z,fx,fy,fz,dx,dy,dz of points under gravity; gives E
  pictures                         [sequence,]force of the samples that --scene records; gives E
or FILE.csv alone with columns F11 ... F33 and P11 ... (nominal) or sigma11 ... (true stress).
All tests of one call are of one material. The header names the units, `Load (N)` or `P_MPa`.
Without a unit a column is in SI units. Remarks above the header are skipped. Forces and
displacements need --diameter or --area, and --height.

The chord modulus is the slope of nominal stress between 10 and 20 % strain, or over the measured
range of a shorter curve. It is divided by the stiffening due to bonded ends. The constitutive
models are neo-Hookean, Mooney-Rivlin, Yeoh and Ogden with 1 to 3 terms. The best model is stable
and has the lowest BIC. A model whose residual is above 10 % of the peak is only a warning. The
lines for a scene are of the best model that a scene reads. Several tests of one kind are several
specimens. Numbers that no soft solid has are rejected.

Examples:
  palpate-slave identify compression=EF10.csv --diameter 50mm --height 30mm --ends bonded --out build/ef10
  palpate-slave identify uniaxial=UT.csv equibiaxial=ET.csv planar=PS.csv --stress-unit MPa --out build/rubber
  palpate-slave identify relaxation=hold.csv --out build/adhesive
  palpate-slave identify press=answers.csv --scene deploy/scenes/foam-cube.yaml --out build/cube
  palpate-slave identify loads=sag.csv --scene beam.yaml --out build/beam
  palpate-slave identify pictures=loadcell.csv --scene recorded.yaml --out build/recorded)";

int RunIdentify(const IdentifyOptions& options, const std::stop_token& stop) {
  const Requests requests = Sort(options);
  const identify::Specimen specimen = SpecimenOf(options);
  std::vector<std::filesystem::path> inputs{requests.press, requests.loads, requests.pictures,
                                            options.scene};
  for (const TableRequest& request : requests.tests) inputs.push_back(request.file);
  for (const TableRequest& request : requests.relaxations) inputs.push_back(request.file);
  RequireOtherThan("--out", options.out, {"report.json"}, inputs);
  IdentifyReport report;
  {
    ProgressBar progress("identify", stop);
    IdentifyLaws(requests, specimen, options.to < kAllStrains, &progress, &report);
    IdentifyRelaxation(requests, specimen, &report);
    if (!options.scene.empty() && !report.fits.empty()) {
      CompareWithScene(LoadScene(options.scene, options.overrides, SceneUse::kSolve),
                       report.tests.front().name, report.fits.front().law.YoungModulus(),
                       "those of the header, --stress-unit, --height, --diameter and --area");
    }
    const bool nothing = report.tests.empty() && report.relaxations.empty() &&
                         requests.press.empty() && requests.loads.empty() &&
                         requests.pictures.empty();
    if (nothing) throw InputError(report.warnings.front());
    if (!requests.press.empty() || !requests.loads.empty()) {
      IdentifyOnScene(requests, options, &progress, &report);
    }
    if (!requests.pictures.empty()) {
      ReportProgress(&progress, "images", 0);
      const Scene scene = LoadScene(options.scene, options.overrides);
      LogRemarks(scene);
      report.pictures = FitPictures(scene, requests.pictures, stop);
    }
  }
  std::filesystem::create_directories(options.out);
  WriteReport(report, options.out);
  std::fputs(ToWords(report).c_str(), stdout);
  return 0;
}

}  // namespace palpate
