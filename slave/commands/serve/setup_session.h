// `palpate-slave serve --setup`: a slave that starts without a scene, and gets one from a client.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "slave/capture/shared_camera.h"
#include "slave/live/live_settings.h"
#include "slave/live/scene_setup.h"
#include "slave/live/switched_slave.h"
#include "slave/scene/scene.h"

namespace palpate {

struct SetupOptions {
  std::filesystem::path folder;     // of saved scenes; created if missing
  std::filesystem::path state_dir;  // see MakeLiveSlave
  ModelChooser choose = {};         // see LiveSlave
};

class SetupSession final : public SceneSetup {
 public:
  // Opens the camera. Throws as OpenFrameSource does; std::runtime_error: the folder cannot be
  // created.
  SetupSession(SetupOptions options, const Camera& camera);

  ProposalReport Check(const SceneProposal& proposal, Progress* progress) override;
  std::function<void()> Prepare(const SceneProposal& proposal, Progress* progress) override;
  FoundBoard FindBoard(const BoardImages& board) override;
  [[nodiscard]] cv::Mat StartImage() override;

  [[nodiscard]] Slave& slave() { return slave_; }

 private:
  [[nodiscard]] FrameOpener Opener() const;

  const SetupOptions options_;
  const SharedCamera camera_;
  SwitchedSlave slave_;
};

// The mistake in a line of a SceneError about `file`, or in the message of another exception.
SceneMistake ParseMistake(std::string text, const std::filesystem::path& file);

}  // namespace palpate
