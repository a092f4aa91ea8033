// `palpate-slave serve --setup`: a slave that gets its scene from a client.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stop_token>

#include "slave/capture/shared_camera.h"
#include "slave/commands/serve/saved_scenes.h"
#include "slave/live/live_slave.h"
#include "slave/live/scene_setup.h"

namespace palpate {

// Outlives its slaves.
class SetupSession final : public SceneSetup {
 public:
  // `folder`: of saved scenes; created if missing. Opens the camera. Throws as OpenFrameSource
  // does; std::runtime_error: the folder cannot be created.
  SetupSession(const std::filesystem::path& folder, const Camera& camera);

  ProposalReport Check(const SceneProposal& proposal, Progress* progress) override;
  std::unique_ptr<PreparedScene> Prepare(const SceneProposal& proposal,
                                         Progress* progress) override;
  FoundOutline FindOutline(const cv::Mat& image, CurveView near) override {
    return FindOutlineNear(image, near);
  }
  FoundBoard FindBoard(const BoardImages& images, Progress* progress) override;
  [[nodiscard]] cv::Mat StartImage(const std::stop_token& stop) override;

  // The slave of the saved scene; one that only shows images, if there is none, or if it cannot
  // start.
  std::unique_ptr<LiveSlave> First();
  // Waits until a scene is taken into use, and returns its slave. Null: `stop`.
  std::unique_ptr<LiveSlave> Next(const std::stop_token& stop);

 private:
  class Prepared;

  [[nodiscard]] std::unique_ptr<LiveSlave> Offered(std::unique_ptr<LiveSlave> slave);
  void Serve(std::unique_ptr<LiveSlave> next);

  const SharedCamera camera_;
  const SavedScenes saved_;
  std::mutex mutex_;  // guards the next ones
  std::condition_variable_any changed_;
  std::unique_ptr<LiveSlave> next_;  // of a scene that was taken into use
};

}  // namespace palpate
