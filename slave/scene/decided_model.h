// The decision of `model.kind: auto` for a scene, as text for the cache and for recordings.
#pragma once

#include <string>
#include <string_view>

#include "slave/scene/scene.h"

namespace palpate {

// JSON, one object: kind, resolution, the solver's options, the decision with its figures.
std::string DecidedText(const Scene& scene);
// Puts it into a scene that is otherwise the same. Returns false without a change if the text is
// not from DecidedText, or the model is not for this object.
[[nodiscard]] bool ApplyDecided(std::string_view text, Scene* scene);
// The decision for people, one line each: the model and the reason, then at most `most` rejected
// ones.
std::vector<std::string> LinesOf(const ModelDecision& decision, std::size_t most);

}  // namespace palpate
