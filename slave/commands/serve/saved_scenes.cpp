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
constexpr const char *kScenes = "palpate-scenes", *kCurrent = "current", *kLast = "last",
                     *kMark = "made-by-palpate";

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

// Puts a link to `target` in the place of `link`, which is a link or absent, by one rename.
void ReplaceLink(const fs::path& target, const fs::path& link) {
  const fs::path fresh = link.string() + ".new";
  fs::remove(fresh);
  fs::create_symlink(target, fresh);
  fs::rename(fresh, link);
}

// Removes the folder of one scene, but no file that a set-up does not write.
void RemoveScene(const fs::path& folder) {
  std::error_code ignored;
  fs::remove(folder / kScene, ignored);
  for (const std::string_view name : kFiles) fs::remove(folder / name, ignored);
  fs::remove(folder, ignored);  // fails if something else is there
}

// Makes the folder with its mark, or recognizes it.
void Own(const fs::path& folder) {
  if (fs::exists(folder / kMark)) return;
  if (fs::exists(fs::symlink_status(folder)) &&
      !(fs::is_directory(folder) && fs::is_empty(folder))) {
    throw std::runtime_error(folder.string() +
                             ": not made by a set-up: move it away, or choose another folder");
  }
  fs::create_directories(folder);
  WriteDurably(folder / kMark,
               "palpate-slave serve --setup made this folder and removes old scenes in it.\n");
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

SavedScenes::SavedScenes(fs::path folder) : folder_(std::move(folder)), scenes_(folder_ / kScenes) {
  Own(scenes());
}

fs::path SavedScenes::file() const {
  std::error_code ignored;
  const fs::path own = scenes() / kCurrent / kScene;
  return fs::exists(own, ignored) ? own : folder_ / kScene;
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

// Makes the links to the files of the scene in `folder`, unless a name belongs to a file of the
// user.
void SavedScenes::Link(const fs::path& folder) const {
  const auto is_own = [&](std::string_view name) {
    std::error_code error;
    const fs::path link = folder_ / name;
    if (!fs::is_symlink(link, error)) return !fs::exists(fs::symlink_status(link, error));
    const std::string target = fs::read_symlink(link, error).string();
    return target.starts_with(std::string(kScenes) + "/");
  };
  if (!is_own(kScene) || !std::ranges::all_of(kFiles, is_own)) return;
  const auto link = [&](std::string_view name) {
    const fs::path target = fs::path(kScenes) / kCurrent / name, at = folder_ / name;
    std::error_code error;
    if (!fs::exists(folder / name)) {
      fs::remove(at, error);
    } else if (fs::read_symlink(at, error) != target) {
      ReplaceLink(target, at);
    }
  };
  link(kScene);
  std::ranges::for_each(kFiles, link);
}

// Removes all scenes except these two.
void SavedScenes::RemoveOthers(const fs::path& present, const fs::path& last) const {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(scenes(), ignored)) {
    const fs::path name = entry.path().filename();
    const bool is_old = NumberOf(name) > 0 && name != present && name != last;
    if (is_old && !entry.is_symlink(ignored)) RemoveScene(entry.path());
  }
}

SavedScenes::Draft::Draft(const SavedScenes& scenes, const SceneProposal& proposal)
    : scenes_(scenes), folder_(scenes.NewFolder()) {
  try {
    WriteProposal(proposal, folder_);
    SyncFolder(scenes_.scenes());
  } catch (...) {
    RemoveScene(folder_);
    throw;
  }
}

SavedScenes::Draft::~Draft() {
  if (!is_used_) RemoveScene(folder_);
}

fs::path SavedScenes::Draft::file() const {
  return folder_ / kScene;
}

void SavedScenes::Draft::Use() {
  std::error_code none;
  const fs::path last = fs::read_symlink(scenes_.scenes() / kCurrent, none);
  ReplaceLink(folder_.filename(), scenes_.scenes() / kCurrent);
  is_used_ = true;
  try {
    SyncFolder(scenes_.scenes());
    if (!last.empty()) ReplaceLink(last, scenes_.scenes() / kLast);
    scenes_.Link(folder_);
    SyncFolder(scenes_.folder_);
  } catch (const std::exception&) {  // the scene is in use, and the previous one still exists
  }
  scenes_.RemoveOthers(folder_.filename(), last);
}

}  // namespace palpate
