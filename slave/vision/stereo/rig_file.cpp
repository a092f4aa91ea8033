// A rig's file, in the manner of OpenCV's FileStorage (which reads it, too):
//
//   %YAML:1.0
//   ---
//   left:                          # one camera: these four at the top, and nothing else
//      image_width: 640
//      image_height: 480
//      camera_matrix: !!opencv-matrix
//         rows: 3
//         cols: 3
//         dt: d
//         data: [ fx, 0., cx, 0., fy, cy, 0., 0., 1. ]
//      distortion_coefficients: ...   1 x 5: k1 k2 p1 p2 k3; 4 are read, too
//   right: ...
//   R: ...                         # p_R = R p_L + T, 3 x 3 and 3 x 1 [m]
//   T: ...
//   rms_px: 0.2
//
// Files of one camera by ROS's camera_calibration are read as they are; a `distortion_model` must
// be plumb_bob, the only one there is here. So are OpenCV's XML and JSON with the same names, and
// ROS's message CameraInfo as text: width, height, K or k, D or d.
#include <cmath>
#include <initializer_list>
#include <stdexcept>

#include <Eigen/LU>
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <yaml-cpp/yaml.h>

#include "shared/text/file_format.h"
#include "shared/text/text.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {
namespace {

// Limits of accepted values, larger than for any rig [by definition]: size of an image [px] and of
// a file [bytes].
constexpr int kMaxImage = 16384;
constexpr std::uintmax_t kMaxFile = 1 << 20;  // [by definition]
// Focal length [px], distance of the cameras [m], and the largest centre of an image [px],
// distortion [-] and rms [px]. [by definition]
constexpr double kMinFocal = 1e-3, kMaxFocal = 1e9, kMinDistance = 1e-12, kMaxDistance = 1e3,
                 kMaxPixels = 1e6;

constexpr const char* kAccepted =
    "a camera rig with image_width, image_height, camera_matrix and distortion_coefficients, as "
    "`calibrate`, OpenCV and ROS write them, of a pair below `left` and `right`";

class RigReader {
 public:
  explicit RigReader(const std::filesystem::path& file) : file_(file) {
    const std::string text = ReadWholeFile(file, kMaxFile, "a camera rig");
    const bool is_xml = Trimmed(text).starts_with("<?xml");
    const std::string foreign = ForeignFormat(std::string_view(text));
    if (!is_xml && !foreign.empty()) Refuse("is " + foreign + ": expected " + kAccepted);
    try {
      root_ = is_xml ? LoadXml(text) : YAML::Load(text);
    } catch (const YAML::Exception& error) {
      Refuse(std::string(error.what()) + ": expected " + kAccepted);
    } catch (const cv::Exception& error) {
      Refuse("is no XML of OpenCV: " + error.err);
    }
    if (!root_.IsMap()) Refuse(std::string("is not a map of keys: expected ") + kAccepted);
  }

  StereoRig Read() const {
    StereoRig rig;
    const bool is_pair = Has(root_, "left") || Has(root_, "right");
    rig.left = ReadLens(is_pair ? Child(root_, "left", "left") : root_, is_pair ? "left." : "");
    if (Has(root_, "rms_px")) rig.rms_px = Number(root_["rms_px"], "rms_px");
    RequireRange("rms_px", rig.rms_px, 0, kMaxPixels, "a distance in pixels");
    if (!is_pair) return rig;
    rig.right = ReadLens(Child(root_, "right", "right"), "right.");
    const std::vector<double> R = Matrix(root_, "R", "R"), T = Matrix(root_, "T", "T");
    if (R.size() != 9) Refuse("R = " + std::to_string(R.size()) + " numbers: expected 3 x 3");
    if (T.size() != 3) Refuse("T = " + std::to_string(T.size()) + " numbers: expected 3 x 1");
    const Eigen::Matrix3d rotation =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data());
    const double skew = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
    if (!(skew < 1e-5) || rotation.determinant() < 0) Refuse("R: expected a rotation");
    rig.X_RL.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
    rig.X_RL.translation() = Eigen::Map<const Eigen::Vector3d>(T.data());
    RequireRange("length of T", rig.baseline(), kMinDistance, kMaxDistance,
                 "two cameras apart [m]");
    return rig;
  }

 private:
  [[noreturn]] void Refuse(const std::string& why) const {
    throw std::runtime_error(file_.string() + ": " + why);
  }
  // Sequences and maps to a depth that no rig exceeds.
  static YAML::Node FromOpenCv(const cv::FileNode& from, int depth = 0) {
    constexpr int kDeepest = 8;
    YAML::Node node;
    if (depth > kDeepest) return node;
    if (from.isInt() || from.isReal()) {
      node = fmt::format("{:.17g}", static_cast<double>(from));
    } else if (from.isString()) {
      node = static_cast<std::string>(from);
    }
    if (!from.isMap() && !from.isSeq()) return node;
    for (const cv::FileNode& child : from) {
      if (from.isMap()) node[child.name()] = FromOpenCv(child, depth + 1);
      if (from.isSeq()) node.push_back(FromOpenCv(child, depth + 1));
    }
    return node;
  }
  static YAML::Node LoadXml(const std::string& text) {
    const cv::FileStorage storage(
        text, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_XML);
    return FromOpenCv(storage.root());
  }
  // The first of these names that the map has; the first of all if it has none.
  static const char* OneOf(const YAML::Node& map, std::initializer_list<const char*> names) {
    for (const char* name : names) {
      if (Has(map, name)) return name;
    }
    return *names.begin();
  }
  static bool Has(const YAML::Node& map, const char* key) {
    return map.IsMap() && map[key].IsDefined();
  }
  YAML::Node Child(const YAML::Node& map, const char* key, const std::string& name) const {
    if (Has(map, key)) return map[key];
    std::string found;
    for (const auto& entry : map.IsMap() ? map : root_) {
      if (entry.first.IsScalar()) found += (found.empty() ? "" : ", ") + entry.first.Scalar();
    }
    Refuse("has no `" + name + "`, only " + Shown(found) + ": expected " + kAccepted);
  }
  void RequireRange(const std::string& name, double value, double least, double most,
                    const char* what) const {
    if (value >= least && value <= most) return;
    Refuse(fmt::format("{} = {:.6g}: expected {}, {:g} to {:g}", name, value, what, least, most));
  }
  double Number(const YAML::Node& node, const std::string& name) const {
    double value = NAN;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      Refuse(name + ": expected a finite number");
    }
    return value;
  }
  std::vector<double> Matrix(const YAML::Node& map, const char* key,
                             const std::string& name) const {
    YAML::Node node = Child(map, key, name);
    if (node.IsMap()) node = Child(node, "data", name + ".data");
    if (!node.IsSequence()) Refuse(name + ": expected a matrix with `data`");
    std::vector<double> values;
    for (const YAML::Node& entry : node) values.push_back(Number(entry, name));
    return values;
  }
  int Pixels(const YAML::Node& map, const char* key, const std::string& name) const {
    const double value = Number(Child(map, key, name), name);
    if (!(value >= 1 && value <= kMaxImage) || value != std::floor(value)) {
      Refuse(fmt::format("{} = {}: expected 1 to {} pixels", name, value, kMaxImage));
    }
    return static_cast<int>(value);
  }

  // Other models have coefficients of the same name, and as many.
  void CheckModel(const YAML::Node& map, const std::string& at) const {
    if (!Has(map, "distortion_model")) return;
    const YAML::Node model = map["distortion_model"];
    const std::string name = model.IsScalar() ? model.Scalar() : "";
    if (name != "plumb_bob") {
      Refuse(at + "distortion_model = " + name + ": expected plumb_bob");
    }
  }

  Lens ReadLens(const YAML::Node& map, const std::string& at) const {
    CheckModel(map, at);
    Lens lens;
    const auto pixels = [&](std::initializer_list<const char*> names) {
      const char* name = OneOf(map, names);
      return Pixels(map, name, at + name);
    };
    const auto matrix = [&](std::initializer_list<const char*> names) {
      const char* name = OneOf(map, names);
      return Matrix(map, name, at + name);
    };
    lens.size = {pixels({"image_width", "width"}), pixels({"image_height", "height"})};
    const std::vector<double> K = matrix({"camera_matrix", "K", "k"});
    if (K.size() != 9) Refuse(at + "camera_matrix: expected 3 x 3");
    lens.fx = K[0], lens.cx = K[2], lens.fy = K[4], lens.cy = K[5];
    const std::string name = at + "camera_matrix: ";
    RequireRange(name + "fx", lens.fx, kMinFocal, kMaxFocal, "a focal > 0 [px]");
    RequireRange(name + "fy", lens.fy, kMinFocal, kMaxFocal, "a focal > 0 [px]");
    RequireRange(name + "cx", lens.cx, -kMaxPixels, kMaxPixels, "a centre [px]");
    RequireRange(name + "cy", lens.cy, -kMaxPixels, kMaxPixels, "a centre [px]");
    if (K[1] != 0 || K[3] != 0 || K[6] != 0 || K[7] != 0 || K[8] != 1) {
      Refuse(at + "camera_matrix: expected [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
    }
    const std::vector<double> d = matrix({"distortion_coefficients", "D", "d"});
    const bool is_message = Has(map, "width");  // there missing coefficients mean no distortion
    if (d.size() < 4 && !(is_message && d.empty()))
      Refuse(at + "distortion_coefficients: expected k1 k2 p1 p2 [k3]");
    for (std::size_t i = 0; i < d.size(); ++i) {
      if (i < lens.distortion.size()) {
        lens.distortion[i] = d[i];
        RequireRange(at + "distortion_coefficients", d[i], -kMaxPixels, kMaxPixels, "a number");
      } else if (d[i] != 0) {
        Refuse(at + "distortion_coefficients: expected k1 k2 p1 p2 k3 (plumb bob); this lens " +
               "has more");
      }
    }
    return lens;
  }

  std::filesystem::path file_;
  YAML::Node root_;
};

std::string MatrixText(const std::string& key, int rows, int cols, const double* row_major,
                       const std::string& indent) {
  std::string data;
  for (int i = 0; i < rows * cols; ++i) {
    data += fmt::format("{}{:.17g}", i == 0 ? "" : ", ", row_major[i]);
  }
  return fmt::format(
      "{0}{1}: !!opencv-matrix\n{0}   rows: {2}\n{0}   cols: {3}\n{0}   dt: d\n"
      "{0}   data: [ {4} ]\n",
      indent, key, rows, cols, data);
}

std::string LensText(const Lens& lens, const std::string& indent) {
  const double K[9] = {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
  return fmt::format("{0}image_width: {1}\n{0}image_height: {2}\n", indent, lens.size[0],
                     lens.size[1]) +
         MatrixText("camera_matrix", 3, 3, K, indent) +
         MatrixText("distortion_coefficients", 1, 5, lens.distortion.data(), indent);
}

}  // namespace

StereoRig ReadRig(const std::filesystem::path& file) {
  return RigReader(file).Read();
}

std::string RigText(const StereoRig& rig) {
  std::string text = "%YAML:1.0\n---\n";
  if (!(rig.baseline() > 0)) {
    text += LensText(rig.left, "");
  } else {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = rig.X_RL.linear();
    const Eigen::Vector3d T = rig.X_RL.translation();
    text += "left:\n" + LensText(rig.left, "   ") + "right:\n" + LensText(rig.right, "   ") +
            "# p_R = R p_L + T [m]\n" + MatrixText("R", 3, 3, R.data(), "") +
            MatrixText("T", 3, 1, T.data(), "");
  }
  return text + fmt::format("rms_px: {:.17g}\n", rig.rms_px);
}

void WriteRig(const std::filesystem::path& file, const StereoRig& rig) {
  WriteWholeFile(file, RigText(rig));
}

}  // namespace palpate
