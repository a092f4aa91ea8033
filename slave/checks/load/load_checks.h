// The checks of the load that is fitted to measured points.
#pragma once

#include <optional>

#include "slave/checks/check.h"
#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_sample.h"
#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {

// Checks of a fit on a flat membrane of `radius` and `thickness` [m]; `prestress` of the scene
// [N/m].
Checks<FitSample> MakePlateChecks(double radius, double thickness, double prestress);
// Checks of a fit on a domed membrane. `rest`: its shape; nullopt: not checked.
Checks<FitSample> MakeDomeChecks(const std::optional<Ellipsoid>& rest);
// Checks of a fit on a volume.
Checks<FitSample> MakeVolumeChecks();
// Checks of every load, after those of its fit.
Checks<LoadSample> MakeLoadChecks();

}  // namespace palpate
