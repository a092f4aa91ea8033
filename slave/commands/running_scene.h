// A scene as it runs: what `model.kind: auto` leaves open is decided.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/scene/scene_loader.h"
#include "slave/study/study.h"

namespace palpate {

// LoadScene; where the kind is `auto`, with the model that an earlier study of the same scene on
// the same kind of machine found, or a quick one of a few seconds now, which is kept. What was
// decided stands in `model.decision` and in the log. `auto` stays where nothing can be studied:
// nothing holds the object, its outline is not known yet, or no force is told.
Scene LoadRunningScene(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                       SceneUse use = SceneUse::kFull, const std::stop_token& stop = {});

// Keeps what `study` decides, if the kind is `auto`, for LoadRunningScene.
void KeepDecision(const study::StudyResult& study, const Scene& scene,
                  const std::vector<std::string>& overrides);

// Where decisions are kept: $XDG_CACHE_HOME/palpate, else ~/.cache/palpate; empty: nowhere.
std::filesystem::path CacheFolder();

}  // namespace palpate
