// `palpate-slave study --shard` and `--merge`: one study shared among several runs or machines.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/study.h"

namespace palpate {

// `3/8`. Throws std::invalid_argument.
study::Shard ParseShard(const std::string& text);

// Measures the shard of `settings`. Its file shard-3-of-8.json in `folder` appears when all is
// measured; until then shard-3-of-8.json.partial has what was. Run again it continues; where its
// file is there, it does nothing. Files of another scene or of other options are replaced. Returns
// 0, or 1 when stopped.
int RunShard(const Scene& scene, const std::vector<std::string>& overrides,
             study::StudySettings settings, const std::filesystem::path& folder,
             const std::stop_token& stop);

struct MergedStudy {
  study::StudyResult study;
  bool is_of_here = true;  // its times are of this machine's kind of processor
};

// The study that the shards in `folder` are parts of. Throws std::invalid_argument: no shards,
// missing ones, shards of several divisions, of another scene, or of other options.
MergedStudy MergeShards(const Scene& scene, const std::vector<std::string>& overrides,
                        study::StudySettings settings, const std::filesystem::path& folder,
                        const std::stop_token& stop);

}  // namespace palpate
