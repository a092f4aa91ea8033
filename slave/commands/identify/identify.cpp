#include "slave/commands/identify/identify.h"

#include <cstdio>
#include <string>

#include "shared/text/text.h"
#include "slave/commands/identify/image_fit.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/scene_remarks.h"

namespace palpate {

const char* const kIdentifyHelp = R"(DATA is KIND=FILE.csv, where KIND is
  uniaxial, tension, compression   stress (or force) against stretch, strain or displacement
  equibiaxial, planar              the same columns; planar: the second direction is fixed
  biaxial, biaxial:RATIO           column stretch_2, or second strain = RATIO x first strain
  shear                            stress against amount of shear
  relaxation                       time, strain or shear, stress; gives a Prony series
  press                            case,x,y,z,dx,dy,dz,fx,fy,fz as `solve` writes them; gives E
  loads                            case,x,y,z,fx,fy,fz,dx,dy,dz of points under gravity; gives E
  images                           [sequence,]force of the samples that --scene records; gives E
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
  palpate-slave identify images=loadcell.csv --scene recorded.yaml --out build/recorded)";

int RunIdentify(const IdentifyOptions& options, const std::stop_token& stop) {
  RequireOtherThan("--out", options.out, {"report.json"}, InputFilesOf(options));
  IdentifyReport report;
  {
    ProgressBar progress("identify", stop);
    const auto fit_images = [&](const Scene& scene, const std::filesystem::path& file) {
      return FitImages(scene, file, stop);
    };
    report = Identify(options, {.remark = LogRemarks, .fit_images = fit_images}, &progress);
  }
  std::filesystem::create_directories(options.out);
  WriteWholeFile(options.out / "report.json", ToJson(report));
  std::fputs(ToWords(report).c_str(), stdout);
  return 0;
}

}  // namespace palpate
