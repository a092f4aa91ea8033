// The folder in which a set-up saves its scenes.
#pragma once

#include <filesystem>
#include <string_view>

#include "slave/live/scene_setup.h"

namespace palpate {

// Returns whether a proposal may contain a file of this name. Only these files enter the folder.
bool IsSetupFile(std::string_view name);

// Each scene has a folder in `palpate-scenes`, numbered from 1, which the set-up makes and marks.
// `current` there is a link to the present scene. Replacing it by one rename activates another
// scene. The previous scene is kept, and `last` points to it. Beside the folder, `scene.yaml`,
// `tip.png`, ... are links to the files of the present scene, where the user has no file of these
// names. No other file is ever moved, changed or removed.
class SavedScenes {
 public:
  // Creates the folder. Throws std::filesystem::filesystem_error; std::runtime_error: somebody else
  // made `palpate-scenes` there.
  explicit SavedScenes(std::filesystem::path folder);

  // The file of the present scene; before the first one a `scene.yaml` of the user. It need not
  // exist.
  [[nodiscard]] std::filesystem::path file() const;

  // A scene that is saved and not in use. It is removed with this object, unless it was used.
  class Draft {
   public:
    // Throws std::runtime_error: the folder cannot be written.
    Draft(const SavedScenes& scenes, const SceneProposal& proposal);
    ~Draft();
    Draft(const Draft&) = delete;
    Draft& operator=(const Draft&) = delete;

    [[nodiscard]] std::filesystem::path file() const;
    // The scene is the present one when this returns, also after a power failure. Throws
    // std::runtime_error: the folder cannot be written, and the scene before is still the present
    // one.
    void Use();

   private:
    const SavedScenes& scenes_;
    const std::filesystem::path folder_;
    bool is_used_ = false;
  };

 private:
  void Link(const std::filesystem::path& folder) const;
  void RemoveOthers(const std::filesystem::path& present, const std::filesystem::path& last) const;
  [[nodiscard]] std::filesystem::path NewFolder() const;
  [[nodiscard]] const std::filesystem::path& scenes() const { return scenes_; }

  const std::filesystem::path folder_, scenes_;
};

// Writes the scene as `scene.yaml`, and the files, into `folder`. Throws std::runtime_error.
void WriteProposal(const SceneProposal& proposal, const std::filesystem::path& folder);

}  // namespace palpate
