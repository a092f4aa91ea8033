// Green's functions of a scene's model, computed by all ranks of an MPI run and written to the
// cache that the slave reads (`model.cache`).
#pragma once

#include <string>

#include "shared/text/progress.h"
#include "slave/precompute/ranks.h"
#include "slave/scene/scene.h"

namespace palpate {

// What was done, for people; on the first rank.
using PrecomputeReport = std::string;

// `scene.model.cache` is the folder; the first rank alone reads and writes it. An interrupted
// computation is taken up, with any number of ranks. All ranks call; `progress` is that of the
// first one, null on others. Throws RanksError: unusable model or scene, or a folder that cannot be
// written; Interrupted.
//
// fem-green: finished groups of columns are taken over. The factor is made again.
PrecomputeReport PrecomputeFemGreen(const Scene& scene, const Ranks& ranks, Progress* progress);
// bem3d: finished blocks of the factor and finished columns are taken over. Integrals are made
// again.
PrecomputeReport PrecomputeBem3d(const Scene& scene, const Ranks& ranks, Progress* progress);

// Reports the first rank's progress. All ranks call. Throws Interrupted on all of them if that is
// what the first one's listener wants.
void ReportTogether(const Ranks& ranks, Progress* progress, std::string_view stage, double done);

}  // namespace palpate
