// A scene, typed and validated: what is modelled, what is sensed, what the operator gets. SI units,
// frames as named. `LoadScene` is the only way to one; what it returns is consistent, so nobody
// checks again.
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
};  // the outline is found by the eyes in the first picture
struct MembraneGeometry {
  double radius = 0, thickness = 0;
};  // [m], clamped plate, frame O at the centre, z along the outward normal
// An air-filled skin: what is left of an ellipsoid above the plane of its rim, which is held.
struct DomeGeometry {
  Eigen::Vector3d semi_axes{0, 0, 0};  // of the ellipsoid along x, y, z of O [m]
  double inflation = 0;                // height of its top above the rim [m]
  double thickness = 0;                // of the skin [m]
  double air = 0;                      // volume of the air that a press shuts in [m^3]; 0: its
                                       // pressure stays
};                                     // frame O at the rim's centre, z outward through the top
struct BoxGeometry {
  Eigen::Vector3d size{0, 0, 0};
  std::array<int, 3> cells{1, 1, 1};
};  // [m], frame O at the lower corner
struct MeshFileGeometry {
  std::filesystem::path file;
  double unit = 1;        // one unit of the file [m]
  double resolution = 0;  // edge asked of the mesher that fills a surface [m]; 0: left to it
};                        // .veg .node/.ele .msh .vtu; a surface: .stl .ply
using Geometry = std::variant<RectangleGeometry, DiscGeometry, PolygonGeometry, ContourFileGeometry,
                              ImageContourGeometry, MembraneGeometry, BoxGeometry, MeshFileGeometry,
                              DomeGeometry>;
bool IsPlanar(const Geometry& geometry);
bool IsVolume(const Geometry& geometry);
// A skin held at its rim: a flat membrane or a domed one.
bool IsSkin(const Geometry& geometry);
double ThicknessOf(const Geometry& geometry);  // [m]; 0: a volume
// The outline of a planar geometry, frame O; a disc as a 360-gon. Empty for ImageContourGeometry
// and what is not planar.
Outline OutlineOf(const Geometry& geometry);

struct Material {
  double young_modulus = 0;            // E [Pa], > 0
  double poisson_ratio = 0;            // nu [-], -1 < nu <= 0.5
  double density = 0;                  // [kg/m^3]; 0: not given
  double young_modulus_tolerance = 0;  // one sigma, relative [-]; goes into the force's sigma
};

// Where displacements are held at zero.
struct FixedSide {
  std::string side;
};  // bottom, top, left, right: of the bounding box, by element midpoint
struct FixedArc {
  double centre = 0, half_angle = 0;
};  // [rad], by element midpoint seen from O's origin, ends within 1e-9 rad
struct FixedPlane {
  int axis = 0;
  double at = 0;
};  // elements whose midpoint lies there [m]
struct FixedNodes {
  std::vector<int> nodes;
};  // element indices from 0
struct Fixed {
  std::variant<FixedSide, FixedArc, FixedPlane, FixedNodes> where;
  std::array<bool, 3> components{true, true, true};  // x, y, z held
};

struct Object {
  Geometry geometry;
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();
  Material material;
  std::vector<Fixed> fixed;  // empty: balanced loads only
};
// Whether something holds the object; a membrane's rim always does. Where nothing does it may move
// as a whole: its points are followed, but what they tell of a force is not known.
bool IsHeld(const Object& object);

// --- tool
struct Tool {
  enum class Shape : std::uint8_t { kFlat, kRound } shape = Shape::kFlat;
  double width = 0;   // across; of a flat one the contact's width [m], > 0
  double radius = 0;  // of a round one's end [m]; its contact grows with the depth
  Eigen::Vector2d direction{
      0, -1};  // unit vector along which the tool points, plane z = 0 of S; zero: the picture tells
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
  // Files: printf pattern, glob, directory or one picture; video: its path. From the working
  // directory: the scene's folder is in it. kUrl: the address.
  std::string pattern;
  std::filesystem::path lens;  // as `calibrate` writes it; empty: no distortion
  int device = 0;              // camera number
  double rate = 60;            // [Hz]
  std::array<int, 2> size{
      640, 480};     // [px] width, height; simulated and device; 0, 0: as the picture comes
  double pixel = 0;  // edge of a pixel in the plane z = 0 of S [m/px]
  Eigen::Isometry3d X_SC =
      Eigen::Isometry3d::Identity();  // C: origin at the picture's centre, x right, y up
};
struct TipTracking {
  std::filesystem::path
      template_file;  // empty: cut from the first picture at the tool's reported place
  std::optional<Eigen::Vector2d>
      anchor;              // tip in the template [px], from its upper left pixel's centre
  int roi = 64;            // edge of the moving search window [px]
  double min_score = 0.6;  // below it the tip is lost [-]
};
struct ContourTracking {
  int control_points = 60;
  double alpha = 1.0, beta = 1.0, gamma = 1.2;  // continuity, curvature, image (paper A, eq. 2)
  // Start shape in the picture [px]; monostate: found automatically.
  struct Circle {
    Eigen::Vector2d centre;
    double radius = 0;
  };
  struct Polygon {
    std::vector<Eigen::Vector2d> points;
  };
  std::variant<std::monostate, Circle, Polygon> start;
};
// One fingertip. Frame F is the electrodes' frame: finger axis x with the tip at +x, pad towards
// -z, origin at the centre of the sphere that rounds the tip off. The tip that the hand moves is
// the apex of the first finger's pad, p_F = (0, 0, -radius).
struct Finger {
  std::string name;                                        // as the source calls it, `rf` say
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();  // while the hand is at manipulator.home
  bool has_pose = false;  // the scene says X_SF; else the pad hangs over the middle of the object
  // How it moves with the hand: along, by the opposite displacement (a pinch), not at all.
  enum class Motion : std::uint8_t { kHand, kOpposite, kStands } motion = Motion::kHand;
};
// Tactile fingertips (paper B).
struct Tactile {
  enum class Source : std::uint8_t { kRecording, kStream, kSimulated } source = Source::kRecording;
  std::filesystem::path file;        // of the recording
  std::filesystem::path poses;       // CSV of fingertip poses; empty: they follow the hand
  double rate = 100;                 // of the samples [Hz]
  std::vector<Finger> fingers;       // 1 to 5; the operator's hand is the first
  std::filesystem::path network;     // folder or .onnx file; empty: forces stay unknown
  bool carries_state = false;        // a network that carries its state on, not the exact window
  int rest_samples = 50;             // whose mean is the rest value
  std::filesystem::path electrodes;  // layout file; empty: that of the simulated fingertip
  std::string localise = "auto";     // auto paper polarity-free pressure-weighted, or a fitted file
  double threshold = 5;              // change of an active electrode [counts]
  double full_scale = 200;           // change of intensity 1 [counts]
  double finger_radius = 7e-3;       // of sphere and cylinder [m]
  double pose_tolerance = 0.035;     // of the fingers' poses, about each axis, one sigma [rad]
  double gate = 0.01;                // farther contacts do not touch the object [m]
  double patch = 0;                  // diameter of a contact's area [m]; 0: a point
  enum class Hold : std::uint8_t { kForce, kDisplacement } hold = Hold::kForce;
};
// A depth camera, real or virtual, that sees the object's shape. D: z forward, x right, y down.
struct DepthCamera {
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();
  std::array<int, 2> size{640, 480};  // [px]
  double focal = 525;                 // [px]
  double noise = 0.002;               // one sigma along the ray [m]
};
// One eye of several that OpenCV or OpenNI2 reads: a camera's number, or an address.
struct Eye {
  enum class Kind : std::uint8_t {
    kDevice,
    kVideo,  // ends, and is paced by the scene's rate
    kUrl,
    kOpenNi  // depth only
  } kind = Kind::kDevice;
  int device = 0;
  std::string address;  // video, URL or GStreamer pipeline
};
// Two cameras, or one with a known lens (paper C). Camera frames L and R: z forward, x right, y
// down, origin at the centre of projection.
struct StereoCameras {
  enum class Source : std::uint8_t {
    kSimulated,
    kFiles,
    kEyes,   // `eyes`
    kStream  // FeedPictures
  } source = Source::kSimulated;
  std::vector<Eye> eyes;      // left, right; one: both side by side in its pictures
  double sync = 5e-3;         // two pictures taken farther apart are no pair [s]
  std::string left, right;    // printf pattern or glob, from the working directory
  std::filesystem::path rig;  // as `calibrate` writes it; empty: the simulated pair's
  double rate = 30;           // [Hz]
  Eigen::Isometry3d X_SL = Eigen::Isometry3d::Identity();  // the left camera
  // Of the simulated pair: parallel but for the vergence that makes both look at the object.
  std::array<int, 2> size{640, 480};  // [px]
  double focal = 800;                 // [px]
  double baseline = 0.06;             // [m]
};
// Depth pictures, pixel for pixel; 0 is no measurement.
struct DepthPictures {
  enum class Source : std::uint8_t { kFiles, kEye, kStream } source = Source::kFiles;
  Eye eye;
  std::string pattern;                                // printf pattern or glob of 16-bit pictures
  double unit = 1e-3;                                 // of a count [m]
  double rate = 30;                                   // [Hz]
  double fx = 525, fy = 525, cx = 319.5, cy = 239.5;  // [px]
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();  // D: z forward, x right, y down
  double sigma = 0.5e-3;                                   // of a depth [m]
};
// Points on the object that the eyes follow.
struct PointTracking {
  enum class Track : std::uint8_t { kDots, kTexture, kSurface } track = Track::kDots;
  int count = 31;                         // dots, or windows of texture
  Eigen::Vector2d spacing{0.015, 0.010};  // of the array of dots, x and y of O [m]
  double dot_radius = 0.002;              // [m]
  std::filesystem::path layout;           // CSV x,y of the dots in O; empty: rows by `spacing`
  std::vector<Eigen::Vector2d> at;        // windows of texture in the first left picture [px]
  int window = 31;                        // edge of a window of texture [px]
  double sigma = 0.1;                     // of a point's place in a picture [px]
};
// One picture in the plane z = 0 of S, in which the tool's tip and the object's outline are
// followed (paper A). Without a camera or a tip nothing is felt: only other uses than the full one
// do with that.
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
// Points in space, on the object, and the eyes that follow them (paper C).
struct PointsOptions {
  StereoOrDepth eyes;
  PointTracking points;

  [[nodiscard]] auto parts() const {
    return std::tuple(std::get_if<StereoCameras>(&eyes), std::get_if<DepthPictures>(&eyes),
                      &points);
  }
};
// A way of feeling, by its options: each is read by a row of kSenseReaders and made by
// MakeSensingPipeline.
using SenseChoice = std::variant<CameraOptions, PointsOptions, Tactile>;

// Calls `use` with the options of a sense and with each of their parts that is there.
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

// The senses of a scene: as many as one likes, but each way of feeling once.
class SenseOptions {
 public:
  // Takes the place of what was felt in the same way before.
  void Set(SenseChoice sense);
  [[nodiscard]] const std::vector<SenseChoice>& all() const { return senses_; }
  // The options of a sense, or a part of them, by type: Tactile, say, or Camera. nullptr: no sense
  // has it.
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

  std::optional<DepthCamera> depth_camera;  // tells a shape, no force

 private:
  std::vector<SenseChoice> senses_;
};
// Two cameras or depth pictures, which follow points in space.
bool HasStereoOrDepth(const SenseOptions& sense);
// Cameras of any kind.
bool HasPictures(const SenseOptions& sense);
// Pictures that a driver pushes (FeedPictures).
bool TakesPictures(const SenseOptions& sense);
// Of the first sense's pictures or samples [Hz]; 0: nothing is sensed.
double SensorRate(const SenseOptions& sense);

// --- model
enum class Plane : std::uint8_t { kStress, kStrain };
enum class ContactLaw : std::uint8_t { kBonded, kFrictionless };
enum class ElementOrder : std::uint8_t { kConstant, kLinear, kQuadratic };
// One term of Ogden's law.
struct OgdenTerm {
  double share = 1;     // of the shear modulus at rest
  double exponent = 2;  // not 0
};
// `fem` and what is made from it (contracts, model options).
struct FemOptions {
  enum class Element : std::uint8_t { kTet4, kTet10 } element = Element::kTet4;
  enum class Law : std::uint8_t {
    kCorotational,
    kLinear,
    kNeoHookean,
    kOgden  // mooney-rivlin and ogden
  } law = Law::kCorotational;
  std::vector<OgdenTerm> terms;  // of kOgden; their shares add up to one
  enum class Time : std::uint8_t { kStatic, kDynamic } time = Time::kStatic;
  enum class Integrator : std::uint8_t {
    kImplicitEuler,
    kNewmark
  } integrator = Integrator::kImplicitEuler;
  enum class Mass : std::uint8_t { kConsistent, kLumped } mass = Mass::kConsistent;
  enum class Tangent : std::uint8_t { kWarped, kExact } tangent = Tangent::kWarped;
  // How the pressure is found: from the displacement alone (locks as nu -> 0.5), averaged over the
  // nodes (tet4), as an unknown of its own (tet10). Auto: displacement for tet4, mixed for tet10
  // from nu = 0.49 on.
  enum class Pressure : std::uint8_t {
    kAuto,
    kDisplacement,
    kAveraged,
    kMixed
  } pressure = Pressure::kAuto;
  double step = 0.02;                  // [s]
  int newton = 1;                      // linear solves per dynamic step; 0: until `residual`
  double damping_mass = 0;             // Rayleigh's a [1/s]
  double damping_stiffness = 0;        // Rayleigh's b [s]
  double residual = 1e-6;              // relative [-]
  Eigen::Vector3d gravity_O{0, 0, 0};  // [m/s^2]
  int threads = 1;                     // of the assembly; the answer does not depend on it
};
// Laws of large strains.
constexpr bool IsHyperelastic(FemOptions::Law law) {
  return law == FemOptions::Law::kNeoHookean || law == FemOptions::Law::kOgden;
}
// A model that `kind: auto` did not take. NaN: not known.
struct RejectedModel {
  std::string model;      // its kind, what it differs in and its resolution
  std::string why;        // one clause
  double error = 0;       // of the contact force, relative [-]
  double update = 0;      // the slowest percent [s]
  double precompute = 0;  // [s]
};
// What `kind: auto` came to. No reason: nothing was decided.
struct ModelDecision {
  std::string reason;  // one sentence: the model, why, its figures; what cannot be met
  bool meets = false;  // tolerance and rate, within the model's range
  double error = 0;    // of the contact force, relative [-]
  std::vector<RejectedModel> rejected;  // those on the way to it first
};
struct ModelOptions {
  std::string kind = "auto";  // or one of kModelKinds
  int elements = 180;
  ElementOrder order = ElementOrder::kConstant;
  int modes = 0;  // of plate-large; 0: its own choice
  FemOptions fem;
  std::filesystem::path cache;  // folder for Green's functions; empty: none is kept
  Plane plane = Plane::kStress;
  ContactLaw contact = ContactLaw::kBonded;
  double tolerance = 0.05;    // asked for [-]
  double rate = 500;          // asked for [Hz]
  double range = 0;           // largest |displacement| / larger side before `extrapolated` [-]
  double puncture_depth = 0;  // overshoot beyond which the puncture cue fires [m]; 0: never
  double puncture_from = 0;   // depth from which a camera may see it [m]; 0: nobody looks
  double prestress = 0;       // of membranes: tension at rest [N/m]
  double wall = 0;            // of a fluid-filled shell: its thickness [m]
  int refinements = 0;        // of a box or a mesh file: how often each edge is cut into halves
  ModelDecision decision;     // the kind above was `auto` before
};

// --- operator, manipulator, site
struct OperatorOptions {
  TeleopTransform transform;   // scales and R_SM; the offset is the clutch's
  double force_limit = 3.3;    // at the device [N]
  double press_depth = 0.005;  // what a scripted hand does, at the tool [m]
  bool press_told = false;     // the scene says how deep
  double press_speed = 0.020;  // [m/s]
};
struct ManipulatorOptions {
  enum class Source : std::uint8_t {
    kSimulated,
    kStream,  // DriveTool
    kMp285    // Sutter MP-285 or MP-225 on a serial line
  } source = Source::kSimulated;
  std::string port;                          // of kMp285: `/dev/ttyUSB0`
  double silence = 0.040;                    // of the arm's reports: longer is a fault [s]
  Eigen::Vector3d home{0, 0, 0};             // tip at start, S [m]
  double max_speed = 0.05;                   // [m/s]
  Eigen::Vector3d workspace_min{-1, -1, 0};  // S [m]
  Eigen::Vector3d workspace_max{1, 1, 0};    // S [m]
  // What protects the target, whoever operates: beyond these the tool goes no deeper.
  double force_guard = std::numeric_limits<double>::infinity();  // [N]
  double depth_guard = std::numeric_limits<double>::infinity();  // [m]
  bool guard_retracts = false;  // out to the surface; else it only holds
  double blind_after = 0.25;    // the tool stands once the force was unknown for so long [s]
};
struct LinkOptions {
  // Both ends take the link for dead after this silence [s]: the tool holds, the hand's force
  // fades.
  double dead_after = kUsualDeadAfter;
};
// What a simulated embryo has beside a body and its light (`site.embryo`). The insertion's puncture
// and the target inside the cell are drawn by the seed.
struct EmbryoSite {
  double radius = 0;        // of the true outline, where only the picture tells the scene's [m]
  double linear_to = 1e-4;  // depth beyond which the membrane stiffens [m]
  double stiffening = 0.3;  // force in parts of the linear one at twice that depth, less 1 [-]
  Eigen::Vector2d puncture{5e-5, 2e-4};  // depths between which the membrane breaks [m]
  double drag = 1e-4;                    // of the liquid on the pipette [N s/m]
  int debris = 12;                       // particles that drift in the picture
  double defocus = 0.4;                  // at its worst, as sigma of a blur [px]
};
// The simulated site's world, unknown to the estimator.
struct SiteOptions {
  std::uint32_t seed = 1;
  double noise = 2.0;      // sigma of the picture noise [grey levels of 255]
  double blur = 0.7;       // sigma of the optical blur [px]
  double lighting = 0.15;  // relative fall of the light across the picture [-]
  double flicker = 0.02;   // relative change of the light in time [-]
  Eigen::Vector2d misplacement{0,
                               0};  // how far the object really is from where the scene says, S [m]
  double pace = 1;  // of a textured target on its path: 1 is paper C's, 17 mm/s at most
  // How the object before one camera moves as a whole, as by breath: to and fro along this way, S
  // [m], a sine of this period [s], from where it rests.
  struct Motion {
    Eigen::Vector2d amplitude{0, 0};
    double period = 3;
  };
  Motion motion;
  std::optional<EmbryoSite> embryo;
  // How long a lamp before one camera stays as it is [s]; 0: there is none. In each other such span
  // of the slave's clock, counted from 1970, a picture has a tenth less light: whoever sees it
  // knows when it was taken, whatever it is stamped. Live pictures only.
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
  // Where `study` presses, O [m]; empty: where the tool would meet the object.
  std::vector<Eigen::Vector3d> study_contacts;
};

// Whether fingertips of the scene meet its object: somebody knows where they are. Otherwise nothing
// deforms and no model is built.
bool MeetsObject(const Scene& scene);

// What the scene is read from, itself first: files, and folders of pictures and networks.
std::vector<std::filesystem::path> InputFilesOf(const Scene& scene);

}  // namespace palpate
