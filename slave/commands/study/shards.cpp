#include "slave/commands/study/shards.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include "shared/program/program.h"
#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/running_scene.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/study/shard_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using study::Shard, study::ShardFile, study::StudyRow;

constexpr const char* kPartial = ".partial";

std::string NameOf(const Shard& shard) {
  return Formatted("shard-%zu-of-%zu.json", shard.index, shard.count);
}

bool IsPart(const Shard& shard) {
  return 1 <= shard.index && shard.index <= shard.count;
}

// nullopt: the file is no shard's.
std::optional<Shard> ShardNamed(const std::string& name) {
  Shard shard;
  const int read = std::sscanf(name.c_str(), "shard-%zu-of-%zu", &shard.index, &shard.count);
  if (read != 2 || !IsPart(shard) || name != NameOf(shard)) return std::nullopt;
  return shard;
}

std::string Fingerprint(const std::string& bytes) {
  const Hash hash = Hash().Add(std::as_bytes(std::span(bytes)));
  return Formatted("%zu bytes with the hash %016llx", bytes.size(),
                   static_cast<unsigned long long>(hash.value()));
}

// What the answers follow from, in words. Paths are left out: they differ between machines.
std::map<std::string, std::string> ConditionsOf(const Scene& scene,
                                                const std::vector<std::string>& overrides) {
  std::string lines;
  for (const std::string& line : overrides) lines += (lines.empty() ? "" : ", ") + line;
  return {{"program", Version()},
          {"scene", scene.name + ", " + Fingerprint(BytesOf(scene.file))},
          {"shape", Fingerprint(BytesOf(ShapeFileOf(scene.object.geometry)))},
          {"overrides", lines.empty() ? "none" : lines}};
}

// nullopt: nothing that a run under these conditions can take.
std::optional<ShardFile> Kept(const fs::path& file, const ShardFile& now) {
  try {
    ShardFile kept = study::ReadShard(file);
    if (kept.conditions == now.conditions) return kept;
  } catch (const std::invalid_argument&) {  // not there, or damaged
  }
  return std::nullopt;
}

// The number of shards, all of which are in the folder.
std::size_t CountShards(const fs::path& folder) {
  constexpr std::size_t kNamed = 8;
  std::set<std::size_t> counts, found;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const auto shard = ShardNamed(entry.path().filename().string());
    if (shard) counts.insert(shard->count), found.insert(shard->index);
  }
  const std::string option = "--merge " + folder.string();
  if (counts.empty()) {
    throw std::invalid_argument(option + ": expected a folder with files of study --shard");
  }
  const std::size_t count = *counts.begin();
  if (counts.size() > 1) {
    throw std::invalid_argument(option + Formatted(": expected one division, found shards "
                                                   "of %zu and of %zu",
                                                   count, *counts.rbegin()));
  }
  const std::size_t missing = count - found.size();
  if (missing == 0) return count;
  std::string names;
  std::size_t named = 0;
  for (Shard shard{1, count}; named < std::min(missing, kNamed); ++shard.index) {
    if (found.contains(shard.index)) continue;
    const bool begun = fs::exists(folder / (NameOf(shard) + kPartial), none);
    names += Formatted("%s%zu/%zu%s", named++ > 0 ? ", " : "", shard.index, count,
                       begun ? " (not finished)" : "");
  }
  if (missing > named) names += Formatted(" and %zu more", missing - named);
  throw std::invalid_argument(option + ": missing are the shards " + names);
}

void RequireSame(const fs::path& file, const ShardFile& shard, const ShardFile& expected) {
  for (const auto& [name, value] : expected.conditions) {
    const auto found = shard.conditions.find(name);
    if (found != shard.conditions.end() && found->second == value) continue;
    const std::string has = found == shard.conditions.end() ? "nothing" : found->second;
    throw std::invalid_argument(Formatted("%s: %s = %s: expected %s", file.c_str(), name.c_str(),
                                          has.c_str(), value.c_str()));
  }
}

}  // namespace

Shard ParseShard(const std::string& text) {
  Shard shard;
  const int read = std::sscanf(text.c_str(), "%zu/%zu", &shard.index, &shard.count);
  if (read == 2 && IsPart(shard) && text == Formatted("%zu/%zu", shard.index, shard.count)) {
    return shard;
  }
  throw std::invalid_argument("--shard " + text +
                              ": expected i/n with 1 <= i <= n, for example 3/8");
}

int RunShard(const Scene& scene, const std::vector<std::string>& overrides,
             study::StudySettings settings, const fs::path& folder, const std::stop_token& stop) {
  const fs::path file = folder / NameOf(*settings.shard), partial = file.string() + kPartial;
  ShardFile shard{ConditionsOf(scene, overrides), Processor(), {}};
  shard.conditions["budget"] = Formatted("%g s", settings.budget_s);
  if (Kept(file, shard)) {
    std::printf("%s: was done before\n", file.c_str());
    return 0;
  }
  if (auto before = Kept(partial, shard); before && before->processor == shard.processor) {
    settings.known = std::move(before->study.rows);
    std::erase_if(settings.known,
                  [](const StudyRow& row) { return row.outcome == study::Outcome::kSkipped; });
  }
  {
    ProgressBar bar("study", stop);
    const auto keep = [&](const study::StudyResult& so_far) {
      shard.study = so_far;
      ReplaceFile(partial, ToJson(shard));
    };
    study::RunStudy(scene, settings, study::RealWorkshop(), stop, {keep, &bar});
  }
  if (stop.stop_requested()) {
    std::printf("%s: stopped: run it again to continue\n", file.c_str());
    return 1;
  }
  ReplaceFile(file, ToJson(shard));
  fs::remove(partial);
  std::printf("%s: %zu models, %zu of them measured before\n", file.c_str(),
              shard.study.rows.size(), settings.known.size());
  return 0;
}

MergedStudy MergeShards(const Scene& scene, const std::vector<std::string>& overrides,
                        study::StudySettings settings, const fs::path& folder,
                        const std::stop_token& stop) {
  MergedStudy merged;
  ShardFile expected{ConditionsOf(scene, overrides), Processor(), {}};
  bool complete = true;
  for (Shard part{1, CountShards(folder)}; part.index <= part.count; ++part.index) {
    const fs::path file = folder / NameOf(part);
    ShardFile shard = study::ReadShard(file);
    expected.conditions.try_emplace("budget", shard.conditions["budget"]);  // that of the first
    RequireSame(file, shard, expected);
    settings.budget_s = shard.study.budget_s;
    complete = complete && shard.study.complete;
    merged.is_of_here = merged.is_of_here && shard.processor == expected.processor;
    std::ranges::move(shard.study.rows, std::back_inserter(settings.known));
  }
  merged.study = study::RunStudy(scene, settings, study::RealWorkshop(), stop);
  merged.study.complete = complete;
  return merged;
}

}  // namespace palpate
