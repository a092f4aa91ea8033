// A validated scene: object, sensing, model and operator. SI units, frames as named. `LoadScene` is
// the only function that creates one. Its result is consistent, so no code checks it again.
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

#include "shared/geometry/teleop_transform.h"
#include "shared/mesh/outline.h"
#include "shared/state/dead_after.h"

namespace palpate {

// --- object
struct RectangleGeometry {
  double width = 0, height = 0, thickness = 0;
};  // [m], frame O at the lower left
struct DiscGeometry {
  double radius = 0, thickness = 0;
};  // [m], frame O at the centre
struct PolygonGeometry {
  Outline outline;
  double thickness = 0;
};  // [m]
struct ContourFileGeometry {
  std::filesystem::path file;
  Outline outline;
  double thickness = 0;
};  // CSV x,y [m]
struct ImageContourGeometry {
  double thickness = 0;
};  // the outline is found in the first image
struct MembraneGeometry {
  double radius = 0, thickness = 0;
};  // [m], clamped plate, frame O at the centre, z along the outward normal
// An air-filled membrane: the part of an ellipsoid above the plane of its rim, which is fixed.
// Frame O at the rim's centre, z outward through the top.
struct DomeGeometry {
  Eigen::Vector3d semi_axes{0, 0, 0};  // semi-axes of the ellipsoid along x, y, z of O [m]
  double inflation = 0;                // height of the top above the rim [m]
  double thickness = 0;                // thickness of the membrane [m]
  double air = 0;  // volume of the enclosed air [m^3]; 0: its pressure is constant
};
struct BoxGeometry {
  Eigen::Vector3d size{0, 0, 0};
  std::array<int, 3> cells{1, 1, 1};
};  // [m], frame O at the lower corner
struct MeshFileGeometry {
  std::filesystem::path file;
  double unit = 1;        // length of one unit of the file [m]
  double resolution = 0;  // edge of the tetrahedra that fill a surface [m]; 0: chosen by the mesher
};                        // .veg .node/.ele .msh .vtu; a surface: .stl .ply
using Geometry = std::variant<RectangleGeometry, DiscGeometry, PolygonGeometry, ContourFileGeometry,
                              ImageContourGeometry, MembraneGeometry, BoxGeometry, MeshFileGeometry,
                              DomeGeometry>;
bool IsPlanar(const Geometry& geometry);
bool IsVolume(const Geometry& geometry);
// A membrane that is fixed at its rim, flat or domed.
bool IsSkin(const Geometry& geometry);
double ThicknessOf(const Geometry& geometry);  // [m]; 0: a volume
// The outline of a planar geometry, frame O; a disc as a 360-gon. Empty for ImageContourGeometry
// and for geometries that are not planar.
Outline OutlineOf(const Geometry& geometry);

struct Material {
  double young_modulus = 0;            // E [Pa], > 0
  double poisson_ratio = 0;            // nu [-], -1 < nu <= 0.5
  double density = 0;                  // [kg/m^3]; 0: not given
  double young_modulus_tolerance = 0;  // one sigma, relative [-]; part of the force's sigma
};

// Where displacements are zero.
struct FixedSide {
  std::string side;
};  // bottom, top, left, right of the bounding box, selected by element midpoint
struct FixedArc {
  double centre = 0, half_angle = 0;
};  // angles of element midpoints seen from O's origin [rad], ends included within 1e-9 rad
struct FixedPlane {
  int axis = 0;
  double at = 0;
};  // elements whose midpoint lies in the plane; position [m]
struct FixedNodes {
  std::vector<int> nodes;
};  // element indices from 0
struct Fixed {
  std::variant<FixedSide, FixedArc, FixedPlane, FixedNodes> where;
  std::array<bool, 3> components{true, true, true};  // fixed components x, y, z
};

struct Object {
  Geometry geometry;
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();
  Material material;
  std::vector<Fixed> fixed;  // empty: balanced loads only
};
// Whether the object has a fixed boundary. The rim of a membrane is always fixed. Without a fixed
// boundary the object may move as a rigid body: its points are tracked and the force is unknown.
bool IsHeld(const Object& object);

// --- tool
struct Tool {
  enum class Shape : std::uint8_t { kFlat, kRound } shape = Shape::kFlat;
  double width = 0;   // width; of a flat tool the contact width [m], > 0
  double radius = 0;  // radius of the end of a round tool [m]; its contact grows with depth
  Eigen::Vector2d direction{
      0, -1};  // unit vector along the tool, in the plane z = 0 of S; zero: found in the image
};

// --- sense
struct Camera {
  enum class Source : std::uint8_t {
    kSimulated,
    kFiles,
    kVideo,
    kDevice,
    kUrl,    // a stream's address or a GStreamer pipeline
    kStream  // FeedPictures
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
  Eigen::Isometry3d X_SC =
      Eigen::Isometry3d::Identity();  // C: origin at the image centre, x right, y up
};
struct TipTracking {
  std::filesystem::path
      template_file;  // empty: cut from the first image at the reported tool position
  std::optional<Eigen::Vector2d>
      anchor;              // tip in the template, from the centre of its upper left pixel [px]
  int roi = 64;            // edge of the moving search window [px]
  double min_score = 0.6;  // a lower score means that tracking is lost [-]
};
struct ContourTracking {
  int control_points = 60;
  double alpha = 1.0, beta = 1.0, gamma = 1.2;  // continuity, curvature, image (paper A, eq. 2)
  // Initial shape in the image [px]; monostate: found automatically.
  struct Circle {
    Eigen::Vector2d centre;
    double radius = 0;
  };
  struct Polygon {
    std::vector<Eigen::Vector2d> points;
  };
  std::variant<std::monostate, Circle, Polygon> start;
};
// One fingertip. Frame F is the frame of the electrodes: finger axis x with the tip at +x, pad
// towards -z, origin at the centre of the sphere at the tip. The manipulator moves the apex of the
// first finger's pad, p_F = (0, 0, -radius).
struct Finger {
  std::string name;  // name in the source, for example `rf`
  Eigen::Isometry3d X_SF =
      Eigen::Isometry3d::Identity();  // while the manipulator is at manipulator.home
  bool has_pose =
      false;  // the scene defines X_SF; otherwise the pad is above the middle of the object
  // Motion relative to the manipulator: the same, opposite (a pinch), or none.
  enum class Motion : std::uint8_t { kHand, kOpposite, kStands } motion = Motion::kHand;
};
// Tactile fingertips (paper B).
struct Tactile {
  enum class Source : std::uint8_t { kRecording, kStream, kSimulated } source = Source::kRecording;
  std::filesystem::path file;     // file of the recording
  std::filesystem::path poses;    // CSV of fingertip poses; empty: they follow the manipulator
  double rate = 100;              // rate of the samples [Hz]
  std::vector<Finger> fingers;    // 1 to 5; the operator moves the first
  std::filesystem::path network;  // folder or .onnx file; empty: forces are unknown
  bool carries_state =
      false;              // the network keeps its state between samples instead of an exact window
  int rest_samples = 50;  // number of samples whose mean is the baseline
  std::filesystem::path electrodes;  // layout file; empty: layout of the simulated fingertip
  std::string localise = "auto";     // auto, paper, polarity-free, pressure-weighted, or a file
  double threshold = 5;              // smallest change of an active electrode [counts]
  double full_scale = 200;           // change of intensity 1 [counts]
  double finger_radius = 7e-3;       // radius of sphere and cylinder of the fingertip [m]
  double pose_tolerance = 0.035;     // one sigma of a finger's pose about each axis [rad]
  double gate = 0.01;  // largest distance from the surface at which a finger is in contact [m]
  double patch = 0;    // diameter of the contact [m]; 0: a point
  enum class Hold : std::uint8_t { kForce, kDisplacement } hold = Hold::kForce;
};
// A depth camera, real or virtual, that measures the object's shape. D: z forward, x right, y down.
struct DepthCamera {
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();
  std::array<int, 2> size{640, 480};  // [px]
  double focal = 525;                 // [px]
  double noise = 0.002;               // one sigma along the ray [m]
};
// One camera that OpenCV or OpenNI2 reads: its number, or an address.
struct Eye {
  enum class Kind : std::uint8_t {
    kDevice,
    kVideo,  // finite, read at the scene's rate
    kUrl,
    kOpenNi  // depth only
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
    kEyes,   // `eyes`
    kStream  // FeedPictures
  } source = Source::kSimulated;
  std::vector<Eye> eyes;      // left, right; one camera: both sides in one image
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
struct DepthPictures {
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
using StereoOrDepth = std::variant<StereoCameras, DepthPictures>;
// Points on the object in space, and the cameras that track them (paper C).
struct PointsOptions {
  StereoOrDepth eyes;
  PointTracking points;

  [[nodiscard]] auto parts() const {
    return std::tuple(std::get_if<StereoCameras>(&eyes), std::get_if<DepthPictures>(&eyes),
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
// Whether a stereo pair or depth camera tracks points in space.
bool HasStereoOrDepth(const SenseOptions& sense);
// Whether the scene has a camera of any kind.
bool HasPictures(const SenseOptions& sense);
// Whether the images come from a driver (FeedPictures).
bool TakesPictures(const SenseOptions& sense);
// Rate of the images or samples of the first sensing [Hz]; 0: no sensing.
double SensorRate(const SenseOptions& sense);

// --- model
enum class Plane : std::uint8_t { kStress, kStrain };
enum class ContactLaw : std::uint8_t { kBonded, kFrictionless };
enum class ElementOrder : std::uint8_t { kConstant, kLinear, kQuadratic };
// One term of the Ogden model.
struct OgdenTerm {
  double share = 1;     // share of the initial shear modulus
  double exponent = 2;  // not 0
};
// Options of `fem` and of the models derived from it (contracts, model options).
struct FemOptions {
  enum class Element : std::uint8_t { kTet4, kTet10 } element = Element::kTet4;
  enum class Law : std::uint8_t {
    kCorotational,
    kLinear,
    kNeoHookean,
    kOgden  // mooney-rivlin and ogden
  } law = Law::kCorotational;
  std::vector<OgdenTerm> terms;  // terms of kOgden; their shares add up to one
  enum class Time : std::uint8_t { kStatic, kDynamic } time = Time::kStatic;
  enum class Integrator : std::uint8_t {
    kImplicitEuler,
    kNewmark
  } integrator = Integrator::kImplicitEuler;
  enum class Mass : std::uint8_t { kConsistent, kLumped } mass = Mass::kConsistent;
  enum class Tangent : std::uint8_t { kWarped, kExact } tangent = Tangent::kWarped;
  // Treatment of the pressure: from the displacement (locks as nu -> 0.5), averaged over the nodes
  // (tet4), or as a separate unknown (tet10). Auto: displacement for tet4, mixed for tet10 from
  // nu = 0.49 on.
  enum class Pressure : std::uint8_t {
    kAuto,
    kDisplacement,
    kAveraged,
    kMixed
  } pressure = Pressure::kAuto;
  double step = 0.02;            // time step [s]
  int newton = 1;                // linear solves per dynamic step; 0: until `residual` is reached
  double damping_mass = 0;       // Rayleigh damping a [1/s]
  double damping_stiffness = 0;  // Rayleigh damping b [s]
  double residual = 1e-6;        // relative residual [-]
  Eigen::Vector3d gravity_O{0, 0, 0};  // [m/s^2]
  int threads = 1;                     // threads of the assembly; they do not change the result
};
// Whether this constitutive model is for large strains.
constexpr bool IsHyperelastic(FemOptions::Law law) {
  return law == FemOptions::Law::kNeoHookean || law == FemOptions::Law::kOgden;
}
// A model that `kind: auto` rejected. NaN: unknown.
struct RejectedModel {
  std::string model;      // kind, variant and resolution
  std::string why;        // reason for the rejection
  double error = 0;       // error of the contact force, relative [-]
  double update = 0;      // 99th percentile of the update time [s]
  double precompute = 0;  // precompute time [s]
};
// The decision of `kind: auto`. An empty reason means that there is none.
struct ModelDecision {
  std::string reason;                   // one sentence: the model, the reason and its figures
  bool meets = false;                   // meets tolerance and rate within the model's range
  double error = 0;                     // error of the contact force, relative [-]
  std::vector<RejectedModel> rejected;  // nearest first
};
struct ModelOptions {
  std::string kind = "auto";  // or one of kModelKinds
  int elements = 180;
  ElementOrder order = ElementOrder::kConstant;
  int modes = 0;  // number of modes of plate-large; 0: its default
  FemOptions fem;
  std::filesystem::path cache;  // folder for Green's functions; empty: none are stored
  Plane plane = Plane::kStress;
  ContactLaw contact = ContactLaw::kBonded;
  double tolerance = 0.05;    // requested relative error of the force [-]
  double rate = 500;          // requested update rate [Hz]
  double range = 0;           // largest |displacement| / larger side that is not `extrapolated` [-]
  double puncture_depth = 0;  // overshoot that triggers the puncture cue [m]; 0: never
  double puncture_from = 0;   // depth from which the camera checks for a puncture [m]; 0: never
  double prestress = 0;       // tension of a membrane at rest [N/m]
  double wall = 0;            // wall thickness of a fluid-filled shell [m]
  int refinements = 0;        // number of times each edge of a box or mesh file is halved
  ModelDecision decision;     // set if the kind above was `auto`
};

// --- operator, manipulator, site
struct OperatorOptions {
  TeleopTransform transform;   // scales and R_SM; the clutch sets the offset
  double force_limit = 3.3;    // at the device [N]
  double press_depth = 0.005;  // indentation of the simulated operator, at the tool [m]
  bool press_told = false;     // the scene defines press_depth
  double press_speed = 0.020;  // speed of the simulated operator, at the tool [m/s]
};
struct ManipulatorOptions {
  enum class Source : std::uint8_t {
    kSimulated,
    kStream,  // DriveTool
    kMp285    // Sutter MP-285 or MP-225 on a serial port
  } source = Source::kSimulated;
  std::string port;               // serial port of kMp285, for example /dev/ttyUSB0
  double silence = 0.040;         // longest time between reports of a driver; more is a fault [s]
  Eigen::Vector3d home{0, 0, 0};  // tool tip at the start, S [m]
  double max_speed = 0.05;        // largest tool speed [m/s]
  Eigen::Vector3d workspace_min{-1, -1, 0};  // lower corner of the workspace, S [m]
  Eigen::Vector3d workspace_max{1, 1, 0};    // upper corner of the workspace, S [m]
  // Protection of the object: beyond these limits the tool moves no deeper.
  double force_guard = std::numeric_limits<double>::infinity();  // [N]
  double depth_guard = std::numeric_limits<double>::infinity();  // [m]
  bool guard_retracts = false;  // retract to the surface; otherwise hold
  double blind_after = 0.25;    // the tool holds after the force was unknown for this time [s]
};
struct LinkOptions {
  // Silence after which both ends regard the link as lost [s]: the tool holds and the rendered
  // force fades.
  double dead_after = kUsualDeadAfter;
};
// Properties of a simulated embryo (`site.embryo`). The seed determines the depth of the puncture
// and the target inside the cell.
struct EmbryoSite {
  double radius = 0;        // radius of the true outline, for `contour: from-image` [m]
  double linear_to = 1e-4;  // depth at which the membrane begins to stiffen [m]
  double stiffening = 0.3;  // force relative to the linear one at twice that depth, minus 1 [-]
  Eigen::Vector2d puncture{5e-5, 2e-4};  // range of depths at which the membrane breaks [m]
  double drag = 1e-4;                    // drag of the liquid on the pipette [N s/m]
  int debris = 12;                       // number of particles that drift in the image
  double defocus = 0.4;                  // largest blur of a varying focus, as sigma [px]
};
// The simulated environment, unknown to the estimator.
struct SiteOptions {
  std::uint32_t seed = 1;
  double noise = 2.0;                  // sigma of the image noise [grey levels of 255]
  double blur = 0.7;                   // sigma of the optical blur [px]
  double lighting = 0.15;              // relative decrease of the light across the image [-]
  double flicker = 0.02;               // relative change of the light over time [-]
  Eigen::Vector2d misplacement{0, 0};  // true position of the object relative to the scene, S [m]
  double pace = 1;  // speed factor of a textured target; 1: path of paper C, at most 17 mm/s
  // Rigid motion of the object in front of one camera, such as breathing: a sine with this
  // amplitude, S [m], and period [s], about the rest position.
  struct Motion {
    Eigen::Vector2d amplitude{0, 0};
    double period = 3;
  };
  Motion motion;
  std::optional<EmbryoSite> embryo;
  // Half period of a lamp in front of one camera [s]; 0: no lamp. In every second half period of
  // the slave's clock, counted from 1970, an image has a tenth less light. This reveals the true
  // time of capture, independent of the timestamp. Live images only.
  double lamp = 0;
};

struct Scene {
  std::string name;
  std::filesystem::path file;
  Object object;
  std::optional<Tool> tool;
  SenseOptions sense;
  ModelOptions model;
  OperatorOptions operator_options;
  ManipulatorOptions manipulator;
  LinkOptions link;
  SiteOptions site;
  // Contact points of `study`, O [m]; empty: where the tool would first touch the object.
  std::vector<Eigen::Vector3d> study_contacts;
};

// Whether the poses of the scene's fingertips are known, so that they can touch the object.
// Otherwise the object is not deformed and no model is built.
bool MeetsObject(const Scene& scene);

// All inputs of the scene, the scene file first: files, and folders of images and networks.
std::vector<std::filesystem::path> InputFilesOf(const Scene& scene);

}  // namespace palpate
