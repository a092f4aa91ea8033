// What one shard of a study measured, as a file.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "slave/study/study.h"

namespace palpate::study {

struct ShardFile {
  std::map<std::string, std::string> conditions;  // equal in all shards of one study
  std::string processor;                          // that the times belong to
  // Only the measured part of its rows, `complete` and `budget_s` are read back.
  StudyResult study;
};

std::string ToJson(const ShardFile& shard);

// Throws std::invalid_argument naming the file: not readable, or no shard.
ShardFile ReadShard(const std::filesystem::path& file);

}  // namespace palpate::study
