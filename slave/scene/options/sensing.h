// Sensing of a scene. SI units, frames as named.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/scene/options/tactile_channels.h"

namespace palpate {

struct Camera {
  enum class Source : std::uint8_t {
    kSimulated,
    kFiles,
    kVideo,
    kDevice,
    kUrl,    // a stream's address or a GStreamer pipeline
    kStream  // FeedImages
  } source = Source::kSimulated;
  // Files: printf pattern, glob, directory or one image. Video: its path. kUrl: the address. Paths
  // are relative to the working directory and include the scene's folder.
  std::string pattern;
  std::filesystem::path lens;  // file from `calibrate`; empty: no distortion
  int device = 0;              // camera number
  double rate = 60;            // [Hz]
  std::array<int, 2> size{
      640, 480};     // width, height of simulated and device images [px]; 0, 0: size of the images
  double pixel = 0;  // edge of a pixel in the plane z = 0 of S [m/px]
  double distance = 0;  // from the projection centre to the plane z = 0 of S [m]; 0: parallel rays
  double pixel_tolerance = 0;  // of the same, one standard deviation, relative [-]
  Eigen::Isometry3d X_SC =
      Eigen::Isometry3d::Identity();  // C: origin at the image centre, x right, y up
};
// Returns whether the file's name is that of a video, not of an image.
bool IsVideo(const std::filesystem::path& file);
struct TipTracking {
  std::filesystem::path
      template_file;  // empty: cut from the first image at the reported tool position
  std::optional<Eigen::Vector2d>
      anchor;                   // tip in the template, from the centre of its upper left pixel [px]
  double anchor_tolerance = 0;  // of the same along the tool, one standard deviation [px]
  int roi = 64;                 // edge of the moving search window [px]
};
struct ContourTracking {
  int control_points = 60;
  double alpha = 1.0, beta = 1.0, gamma = 1.2;  // continuity, curvature, image (paper A, eq. 2)
  // Corners of the initial polygon in the image [px]; empty: found automatically.
  std::vector<Eigen::Vector2d> start;
};
// One fingertip. Frame F is the frame of the electrodes: finger axis x with the tip at +x, pad
// towards -z, origin at the centre of the sphere at the tip. The manipulator moves the apex of the
// first finger's pad, p_F = (0, 0, -radius).
struct Finger {
  std::string name;  // name in the source, for example `rf`
  Eigen::Isometry3d X_SF =
      Eigen::Isometry3d::Identity();  // while the manipulator is at manipulator.home
  bool has_pose =
      false;  // the scene defines X_SF; false: the pad is above the centre of the object
  // Motion relative to the manipulator: the same, opposite (a pinch), or none.
  enum class Motion : std::uint8_t { kHand, kOpposite, kAtRest } motion = Motion::kHand;
};
// Tactile fingertips (paper B).
struct Tactile {
  enum class Source : std::uint8_t { kRecording, kStream, kSimulated } source = Source::kRecording;
  std::filesystem::path file;  // file of the recording
  // The recording contains poses; false: they follow the manipulator.
  bool has_recorded_poses = false;
  double rate = 100;                 // rate of the samples [Hz]
  TactileChannels channels;          // of each finger
  std::vector<Finger> fingers;       // 1 to 5; the operator moves the first
  std::filesystem::path network;     // folder with network.json; empty: forces are unknown
  int rest_samples = 50;             // number of samples whose mean is the baseline
  std::filesystem::path electrodes;  // layout file of electrodes or channels; empty: none
  double finger_radius = 7e-3;       // radius of sphere and cylinder of the fingertip [m]
  double pose_tolerance = 0.035;     // one sigma of a finger's pose about each axis [rad]
  double gate =
      0.01;  // largest distance from the surface at which a finger is in contact [m]; no key
  double patch = 0;  // diameter of the contact [m]; 0: a point
  enum class Hold : std::uint8_t { kForce, kDisplacement } hold = Hold::kForce;
};
// A depth camera, real or virtual, that measures the object's shape. D: z forward, x right, y down.
struct DepthCamera {
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();
  std::array<int, 2> size{640, 480};  // [px]
  double focal = 525;                 // [px]
  double noise = 0.002;               // one sigma along the ray [m]
};
// One camera that OpenCV reads: its number, or an address.
struct Eye {
  enum class Kind : std::uint8_t {
    kDevice,
    kVideo,  // finite, read at the scene's rate
    kUrl
  } kind = Kind::kDevice;
  int device = 0;
  std::string address;  // video, URL or GStreamer pipeline
};
// A stereo pair (paper C). Camera frames L and R: z forward, x right, y
// down, origin at the centre of projection.
struct StereoCameras {
  enum class Source : std::uint8_t {
    kSimulated,
    kFiles,
    kCameras,  // `cameras`
    kStream    // FeedImages
  } source = Source::kSimulated;
  std::vector<Eye> cameras;   // left, right; one camera: both sides in one image
  double sync = 5e-3;         // largest time between the two images of a pair [s]
  std::string left, right;    // printf pattern or glob, from the working directory
  std::filesystem::path rig;  // file from `calibrate`; empty: the simulated pair's
  double rate = 30;           // [Hz]
  Eigen::Isometry3d X_SL = Eigen::Isometry3d::Identity();  // pose of the left camera
  // Simulated pair: parallel cameras, rotated so that both point at the object.
  std::array<int, 2> size{640, 480};  // [px]
  double focal = 800;                 // [px]
  double baseline = 0.06;             // [m]
};
// Depth images, one depth per pixel; 0: no measurement.
struct DepthImages {
  enum class Source : std::uint8_t { kFiles, kEye, kStream } source = Source::kFiles;
  Eye eye;
  std::string pattern;                                // printf pattern or glob of 16-bit images
  double unit = 1e-3;                                 // depth of one count [m]
  double rate = 30;                                   // [Hz]
  double fx = 525, fy = 525, cx = 319.5, cy = 239.5;  // [px]
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();  // D: z forward, x right, y down
  double sigma = 0.5e-3;                                   // one sigma of a depth [m]
};
// Points on the object that the cameras track.
struct PointTracking {
  enum class Track : std::uint8_t { kDots, kTexture, kSurface } track = Track::kDots;
  int count = 31;                         // number of dots, or of texture windows
  Eigen::Vector2d spacing{0.015, 0.010};  // spacing of the array of dots along x and y of O [m]
  double dot_radius = 0.002;              // radius of a dot [m]
  std::filesystem::path layout;           // CSV x,y of the dots in O; empty: rows by `spacing`
  std::vector<Eigen::Vector2d> at;        // texture windows in the first left image [px]
  int window = 31;                        // edge of a texture window [px]
  double sigma = 0.1;                     // one sigma of a point's position in an image [px]
};
// One camera for the plane z = 0 of S, in which the tool tip and the object's outline are tracked
// (paper A). Camera and tip are absent only in uses without force estimation.
struct CameraOptions {
  std::optional<Camera> camera;
  std::optional<TipTracking> tip;
  std::optional<ContourTracking> contour;

  [[nodiscard]] auto parts() const {
    return std::tuple(camera ? &*camera : nullptr, tip ? &*tip : nullptr,
                      contour ? &*contour : nullptr);
  }
};
using StereoOrDepth = std::variant<StereoCameras, DepthImages>;
// Points on the object in space, and the cameras that track them (paper C).
struct PointsOptions {
  StereoOrDepth cameras;
  PointTracking points;

  [[nodiscard]] auto parts() const {
    return std::tuple(std::get_if<StereoCameras>(&cameras), std::get_if<DepthImages>(&cameras),
                      &points);
  }
};
// Options of one kind of sensing. A row of kSenseReaders reads them and MakeSensingPipeline uses
// them.
using SenseChoice = std::variant<CameraOptions, PointsOptions, Tactile>;

// Calls `use` with the options of one sensing and with each part that is present.
template <typename Options, typename Use>
void ForEachPart(const Options& options, const Use& use) {
  use(options);
  if constexpr (requires { options.parts(); }) {
    const auto use_it = [&](const auto* part) {
      if (part != nullptr) use(*part);
    };
    std::apply([&](const auto*... part) { (use_it(part), ...); }, options.parts());
  }
}

// The sensing of a scene: any number of kinds, each at most once.
class SenseOptions {
 public:
  // Replaces the options of the same kind.
  void Set(SenseChoice sense);
  [[nodiscard]] const std::vector<SenseChoice>& all() const { return senses_; }
  // The options of this type, or the part of this type, for example Tactile or Camera. nullptr: no
  // sensing has it.
  template <typename Part>
  [[nodiscard]] const Part* Find() const {
    const Part* found = nullptr;
    const auto take = [&](const auto& part) {
      if constexpr (std::is_same_v<decltype(part), const Part&>) found = &part;
    };
    for (const SenseChoice& sense : senses_) {
      std::visit([&](const auto& options) { ForEachPart(options, take); }, sense);
    }
    return found;
  }
  template <typename Part>
  [[nodiscard]] Part* Find() {
    return const_cast<Part*>(std::as_const(*this).Find<Part>());
  }

  std::optional<DepthCamera> depth_camera;  // measures a shape, no force

 private:
  std::vector<SenseChoice> senses_;
};
// Returns whether a stereo pair or depth camera tracks points in space.
bool HasStereoOrDepth(const SenseOptions& sense);
// Returns whether the scene has a camera of any kind.
bool HasImages(const SenseOptions& sense);
// Returns whether the images come from a driver (FeedImages).
bool TakesImages(const SenseOptions& sense);
// Rate of the images or samples of the first sensing [Hz]; 0: no sensing.
double SensorRate(const SenseOptions& sense);

}  // namespace palpate
