#include "slave/commands/serve/saved_scenes.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kScene = "scene.yaml";
constexpr std::array<std::string_view, 4> kFiles{"tip.png", "outline.csv", "lens.yaml",
                                                 "image.jpg"};
constexpr const char *kCurrent = "current", *kLast = "last";

// Returns the number of a scene's folder; 0 for other folders.
int NumberOf(const fs::path& folder) {
  const std::string name = folder.filename().string();
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc() && end == name.data() + name.size() ? number : 0;
}

// Writes a file and waits until it is on the disk.
void WriteDurably(const fs::path& file, std::string_view bytes) {
  const auto write = [&](std::FILE* out) {
    return std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size() &&
           std::fflush(out) == 0 && fsync(fileno(out)) == 0;
  };
  if (!TryReplace(file, write, Links::kReplace)) {
    throw std::runtime_error(file.string() + ": cannot be written");
  }
}

// Waits until the names in a folder are on the disk.
void SyncFolder(const fs::path& folder) {
  const int opened = open(folder.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_done = opened >= 0 && fsync(opened) == 0;
  if (opened >= 0) close(opened);
  if (!is_done) throw std::runtime_error(folder.string() + ": cannot be written");
}

// Puts a link to `target` in the place of `link`, by one rename.
void ReplaceLink(const fs::path& target, const fs::path& link) {
  const fs::path fresh = link.string() + ".new";
  fs::remove(fresh);
  fs::create_symlink(target, fresh);
  fs::rename(fresh, link);
}

}  // namespace

bool IsSetupFile(std::string_view name) {
  return std::ranges::find(kFiles, name) != kFiles.end();
}

void WriteProposal(const SceneProposal& proposal, const fs::path& folder) {
  WriteDurably(folder / kScene, proposal.scene);
  for (const auto& [name, content] : proposal.files) WriteDurably(folder / name, content);
  SyncFolder(folder);
}

SavedScenes::SavedScenes(fs::path folder) : folder_(std::move(folder)) {
  fs::create_directories(scenes());
}

fs::path SavedScenes::file() const {
  return folder_ / kScene;
}

fs::path SavedScenes::NewFolder() const {
  int last = 0;
  for (const auto& entry : fs::directory_iterator(scenes())) {
    last = std::max(last, NumberOf(entry.path()));
  }
  const fs::path folder = scenes() / std::to_string(last + 1);
  fs::create_directory(folder);
  return folder;
}

// Saves plain files in place of the links as a scene. An earlier release, a person or an editor
// wrote them.
void SavedScenes::AdoptPlainFiles() const {
  const auto is_plain = [&](std::string_view name) {
    return fs::symlink_status(folder_ / name).type() == fs::file_type::regular;
  };
  if (!is_plain(kScene) && std::ranges::none_of(kFiles, is_plain)) return;
  const fs::path adopted = NewFolder();
  try {
    const auto copy = [&](std::string_view name) {
      if (!fs::is_regular_file(folder_ / name)) return;
      constexpr std::uintmax_t kMaxBytes = 64 << 20;
      WriteDurably(adopted / name, ReadWholeFile(folder_ / name, kMaxBytes, "a file of a scene"));
    };
    copy(kScene);
    std::ranges::for_each(kFiles, copy);
    SyncFolder(adopted);
    ReplaceLink(adopted.filename(), scenes() / kCurrent);
    Link(adopted);
  } catch (...) {
    std::error_code ignored;
    if (fs::read_symlink(scenes() / kCurrent, ignored) != adopted.filename()) {
      fs::remove_all(adopted, ignored);
    }
    throw;
  }
}

// Makes the links to the files of the scene in `folder`.
void SavedScenes::Link(const fs::path& folder) const {
  const auto link = [&](std::string_view name) {
    const fs::path target = fs::path("scenes") / kCurrent / name;
    std::error_code error;
    if (!fs::exists(folder / name) || fs::read_symlink(folder_ / name, error) == target) return;
    ReplaceLink(target, folder_ / name);
  };
  link(kScene);
  std::ranges::for_each(kFiles, link);
}

// Removes all scenes except these two, and links whose target no longer exists.
void SavedScenes::RemoveOthers(const fs::path& present, const fs::path& last) const {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(scenes(), ignored)) {
    const fs::path name = entry.path().filename();
    const bool is_old = NumberOf(name) > 0 && name != present && name != last;
    if (is_old && !entry.is_symlink(ignored)) fs::remove_all(entry.path(), ignored);
  }
  for (const std::string_view name : kFiles) {
    const fs::path link = folder_ / name;
    if (fs::is_symlink(link, ignored) && !fs::exists(link, ignored)) fs::remove(link, ignored);
  }
}

SavedScenes::Draft::Draft(const SavedScenes& scenes, const SceneProposal& proposal)
    : scenes_(scenes), folder_((scenes.AdoptPlainFiles(), scenes.NewFolder())) {
  try {
    WriteProposal(proposal, folder_);
    SyncFolder(scenes_.scenes());
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    throw;
  }
}

SavedScenes::Draft::~Draft() {
  std::error_code ignored;
  if (!is_used_) fs::remove_all(folder_, ignored);
}

fs::path SavedScenes::Draft::file() const {
  return folder_ / kScene;
}

void SavedScenes::Draft::Use() {
  std::error_code none;
  const fs::path last = fs::read_symlink(scenes_.scenes() / kCurrent, none);
  scenes_.Link(folder_);
  SyncFolder(scenes_.folder_);
  ReplaceLink(folder_.filename(), scenes_.scenes() / kCurrent);
  is_used_ = true;
  try {
    SyncFolder(scenes_.scenes());
    if (!last.empty()) ReplaceLink(last, scenes_.scenes() / kLast);
  } catch (const std::exception&) {  // the scene is in use, and the previous one still exists
  }
  scenes_.RemoveOthers(folder_.filename(), last);
}

}  // namespace palpate
