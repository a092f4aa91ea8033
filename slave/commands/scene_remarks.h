// A scene as a command runs it, and the remarks that every command prints.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/scene/scene_loader.h"

namespace palpate {

// Lists parts of a mesh file that are unused or look wrong, and implausible numbers: the object's
// size and material, gravity (shared/text/plausible.h), a tool wider than the
// object, a pixel larger than 5 mm, a baseline larger than the distance. A file that cannot be read
// has no remarks: it is refused where it is used.
std::vector<std::string> RemarksOn(const Scene& scene);
// Writes them to the log as warnings.
void LogRemarks(const Scene& scene);

// LoadScene, with the chosen model in the place of `kind: auto`. Logs the remarks, and the choice
// with its reason.
Scene LoadRunningScene(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                       SceneUse use = SceneUse::kFull);

// States in a sentence the risk of a missing force guard or depth guard; empty: both are set.
std::string MissingGuards(const ManipulatorOptions& arm);

}  // namespace palpate
