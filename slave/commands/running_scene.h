// A scene as it runs: with `model.kind: auto` decided.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/scene/scene_loader.h"
#include "slave/study/study.h"

namespace palpate {

// LoadScene. For the kind `auto` it sets the model that an earlier study of the same scene on the
// same kind of machine found. Without one it runs a quick study of a few seconds and stores the
// decision. The decision is in `model.decision` and in the log. `auto` stays if nothing can be
// studied: no fixed boundary, an unknown outline, or no force estimation.
Scene LoadRunningScene(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                       SceneUse use = SceneUse::kFull, const std::stop_token& stop = {});

// Stores the decision of `study` for LoadRunningScene, if the kind is `auto`.
void KeepDecision(const study::StudyResult& study, const Scene& scene,
                  const std::vector<std::string>& overrides);

// States in a sentence the risk of a missing force guard or depth guard; empty: both are set.
std::string MissingGuards(const ManipulatorOptions& arm);

// Folder of stored decisions: $XDG_CACHE_HOME/palpate, else ~/.cache/palpate; empty: none.
std::filesystem::path CacheFolder();

}  // namespace palpate
