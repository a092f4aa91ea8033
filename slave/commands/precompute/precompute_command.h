// `palpate-slave precompute`: fills the cache of Green's functions (`model.cache`) of `fem-green`.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct PrecomputeOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
};

// Groups in the cache are not computed again unless they are damaged. Returns 0. Throws SceneError;
// std::invalid_argument: another kind of model, no cache, a body that is not held;
// std::runtime_error: the cache cannot be written; Interrupted.
int RunPrecompute(const PrecomputeOptions& options, const std::stop_token& stop);

}  // namespace palpate
