#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/text/svg.h"
#include "shared/text/text.h"
#include "slave/commands/identify/identify_report.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using identify::MaterialTest;
using Points = std::vector<Vector2d>;

constexpr double kPanel = 260, kGap = 70, kTop = 50;
constexpr int kColumns = 4;
constexpr const char* kStyle =
    "text{font:12px sans-serif;fill:#222}.title{font-size:13px;font-weight:bold}"
    ".small{font-size:10px}.paper{fill:#fff}.frame{fill:none;stroke:#999}"
    ".seen{fill:#4878a8;fill-opacity:0.7}.law{fill:none;stroke:#c44e52;stroke-width:1.5}"
    ".band{fill:#c44e52;fill-opacity:0.2}\n";

struct Curve {
  std::string title, x, y;  // with the axes' names and units
  Points seen, law, band;   // the band closed
};

std::string AxisOf(identify::TestKind kind, bool shear_entry) {
  if (kind == identify::TestKind::kRelaxation) return "strain [-]";
  return kind == identify::TestKind::kShear || shear_entry ? "amount of shear [-]" : "stretch [-]";
}

Curve CurveOf(const MaterialTest& test, const identify::LawFit& fit) {
  const auto& [along, face] = test.components.front();
  Curve curve{test.name + " (" + std::string(NameOf(test.kind)) + ")",
              AxisOf(test.kind, along != face),
              test.cauchy ? "true stress [Pa]" : "nominal stress [Pa]",
              {},
              {},
              {}};
  const Eigen::VectorXd said = Predict(fit.law, test);
  for (std::size_t i = 0; i < test.rows.size(); ++i) {
    const double x = AbscissaOf(test, test.rows[i], 0);
    const auto at = static_cast<Eigen::Index>(i * test.components.size());
    curve.seen.emplace_back(x, test.rows[i].measured.front());
    curve.law.emplace_back(x, said[at]);
  }
  std::ranges::sort(curve.law, {}, [](const Vector2d& p) { return p.x(); });
  return curve;
}

Curve CurveOf(const identify::PredictedCurve& predicted) {
  Curve curve{predicted.name + " (not measured)",
              AxisOf(predicted.kind, false),
              "nominal stress [Pa]",
              {},
              {},
              {}};
  for (const identify::PredictedRow& row : predicted.rows) {
    curve.law.emplace_back(row.abscissa, row.stress);
    curve.band.emplace_back(row.abscissa, row.low);
  }
  for (auto row = predicted.rows.rbegin(); row != predicted.rows.rend(); ++row) {
    curve.band.emplace_back(row->abscissa, row->high);
  }
  return curve;
}

Curve CurveOf(const identify::RelaxationTable& table, const double* fitted) {
  Curve curve{table.name + " (relaxation)", "time [s]", "stress [Pa]", {}, {}, {}};
  for (std::size_t i = 0; i < table.time.size(); ++i) {
    curve.seen.emplace_back(table.time[i], table.stress[i]);
    curve.law.emplace_back(table.time[i], fitted[i]);
  }
  return curve;
}

void Draw(const Curve& curve, const Vector2d& corner, Svg* svg) {
  Vector2d low(1e300, 0), high(-1e300, 0);
  for (const Points* points : {&curve.seen, &curve.law, &curve.band}) {
    for (const Vector2d& p : *points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  const Vector2d size = (high - low).cwiseMax(1e-300);
  const auto place = [&](const Vector2d& p) {
    const Vector2d share = (p - low).cwiseQuotient(size);
    return Vector2d(corner.x() + kPanel * share.x(), corner.y() + kPanel * (1 - share.y()));
  };
  const auto placed = [&](const Points& points) {
    Points all;
    for (const Vector2d& p : points) all.push_back(place(p));
    return all;
  };
  svg->Text(corner - Vector2d(0, 8), curve.title, "title");
  svg->Rectangle(corner, {kPanel, kPanel}, "frame");
  if (!curve.band.empty()) svg->Polygon(placed(curve.band), "band");
  for (const Vector2d& p : placed(curve.seen)) svg->Circle(p, 2, "seen");
  if (!curve.law.empty()) svg->Polyline(placed(curve.law), "law");
  const Vector2d foot = corner + Vector2d(0, kPanel + 14);
  svg->Text(foot, Formatted("%.4g", low.x()), "small");
  svg->Text(foot + Vector2d(kPanel, 0), Formatted("%.4g", high.x()), "small", Svg::Anchor::kEnd);
  svg->Text(corner + Vector2d(-4, 10), Formatted("%.3g", high.y()), "small", Svg::Anchor::kEnd);
  svg->Text(corner + Vector2d(-4, kPanel), Formatted("%.3g", low.y()), "small", Svg::Anchor::kEnd);
  svg->Text(foot + Vector2d(kPanel / 2, 0), curve.x, "small", Svg::Anchor::kMiddle);
  svg->Text(corner + Vector2d(-8, kPanel / 2), curve.y, "small", Svg::Anchor::kMiddle, -90);
}

std::vector<Curve> CurvesOf(const IdentifyReport& report) {
  std::vector<Curve> curves;
  for (const MaterialTest& test : report.tests) {
    curves.push_back(CurveOf(test, report.fits.front()));
  }
  for (const auto& predicted : report.predictions) curves.push_back(CurveOf(predicted));
  std::size_t at = 0;
  for (const auto& table : report.relaxations) {
    curves.push_back(CurveOf(table, report.prony->fitted.data() + at));
    at += table.time.size();
  }
  return curves;
}

}  // namespace

std::string DrawIdentify(const IdentifyReport& report) {
  const std::vector<Curve> curves = CurvesOf(report);
  const int rows = std::max(1, (static_cast<int>(curves.size()) + kColumns - 1) / kColumns);
  const double width = kGap + kColumns * (kPanel + kGap);
  const double height = 2 * kTop + rows * (kPanel + kGap);
  Svg svg(width, height, "Material identified from tests", kStyle);
  svg.Rectangle({0, 0}, {width, height}, "paper");
  std::string title = "measured: dots; line: ";
  title += report.fits.empty() ? "fit" : report.fits.front().law.name;
  svg.Text({kGap, 20}, title, "title");
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const auto at = static_cast<int>(i);
    Draw(curves[i],
         {kGap + (at % kColumns) * (kPanel + kGap), kTop + 10 + (at / kColumns) * (kPanel + kGap)},
         &svg);
  }
  return svg.Document();
}

}  // namespace palpate
