// The simulated site of a scene with two cameras: a membrane under a large-strain law on a mesh of
// its own, or a textured target on its path. It shows itself through pictures only.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/site/points/pressed_membrane.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

struct StereoPictures {
  cv::Mat left, right;  // 8 bit grey
};

// Frame S.
struct MembraneTruth {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // of the tool [m]
  bool in_contact = false;
  Eigen::Vector3d force{0, 0, 0};  // of the object on the tool [N]
  double depth = 0;                // of the membrane under the tool's centre [m]
  // False: the tool is deeper, or nearer to the rim, than presses are solved, or they are not
  // solved yet (MoveToolAtOnce). The pictures show the nearest ones, carried to the tool's place,
  // and the force is theirs, beyond their depth extrapolated: a guess.
  bool solved = true;
};

// Of a textured target, a rigid body. Frame B as TexturedTarget has it.
struct TargetTruth {
  double seconds = 0;  // on its path, since the first pictures
  Eigen::Isometry3d X_SB_first = Eigen::Isometry3d::Identity();  // in the first pictures
  Eigen::Isometry3d X_SB = Eigen::Isometry3d::Identity();        // in the last ones
  // Where the body's point is in the last pictures that was at `p_S_first` [m] in the first ones.
  [[nodiscard]] Eigen::Vector3d PlaceOf(const Eigen::Vector3d& p_S_first) const {
    return X_SB * (X_SB_first.inverse() * p_S_first);
  }
};

// What is simulated follows from the scene:
// - a membrane, under a flat round tool of the scene's width, and under the tension at rest that
//   the scene tells its model (`model.prestress`), for want of another: dark dots (`track: dots`)
//   or a fine texture (`track: texture`) on its inner face. The tool does not rub: its place on the
//   membrane is where its tip is over it, and as deep as the tip is below the rest plane z_O = 0.
//   Presses are solved ahead (slave/site/stereo/presses_ahead.h) and blended in between (dent.h),
//   exactly at the radius of manipulator.home, elsewhere within 0.6 % of the force.
// - anything else with `track: texture`: the textured target of paper C's second experiment on its
//   path about the origin of O, whatever the object's own shape. Frame B is turned as O; time goes
//   on by 1 / rate from one pair of pictures to the next.
class StereoSite {
 public:
  // Throws std::invalid_argument naming the key where the scene cannot be simulated: no simulated
  // pair (slave/site/stereo/pair_rig.h), no points or no tool, an object that cannot carry the
  // points, dots beyond the rim.
  explicit StereoSite(const Scene& scene, const site::MembraneResolution& resolution = {});
  ~StereoSite();
  StereoSite(const StereoSite&) = delete;
  StereoSite& operator=(const StereoSite&) = delete;

  // The manipulator carries the tool here. Thread-safe. Short, unless the press is deeper than what
  // is solved so far: then it waits. Places that are not finite are ignored; a target is not
  // touched.
  void MoveTool(const Eigen::Vector3d& p_S_tip);
  // For a hand that must not be held up: never waits. Where the presses around the tool are not
  // solved as deep as it is, they are solved next (a log line tells, once per radius), and until
  // they are, truth().solved is false. When they are, the membrane jumps from what was guessed to
  // what is true. A site is moved by one of the two, not by both in turn.
  void MoveToolAtOnce(const Eigen::Vector3d& p_S_tip);
  // From now on presses are solved all over the membrane, in the background, nearest to home first
  // but those under the tool before all. About a second each, a dozen of them.
  void SolveEverywhere();
  [[nodiscard]] bool is_solved_everywhere() const;
  // How often MoveTool waited for a press.
  [[nodiscard]] std::uint64_t waits() const;
  [[nodiscard]] MembraneTruth truth() const;
  // nullopt: a membrane. Thread-safe.
  [[nodiscard]] std::optional<TargetTruth> target() const;
  // True displacement of the membrane's point that rests at p_O [m] on the inner face, frame O.
  // For reports. Thread-safe.
  [[nodiscard]] Eigen::Vector3d TrueDisplacement(const Eigen::Vector2d& p_O) const;
  // Both cameras at once, noise, blur and light as the scene's `site` says. One thread; the same
  // calls in the same order give the same pictures.
  StereoPictures TakePictures();
  // The pair as it really is.
  [[nodiscard]] const StereoRig& rig() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace palpate
