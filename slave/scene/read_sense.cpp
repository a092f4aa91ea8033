#include <algorithm>
#include <system_error>

#include <fnmatch.h>

#include "shared/text/text.h"
#include "slave/scene/sections.h"

namespace palpate {
bool IsVideo(const std::filesystem::path& file) {
  const std::string extension = Lowercase(file.extension().string());
  constexpr std::array kVideos{".avi", ".mp4", ".mkv", ".mov"};
  return std::ranges::find(kVideos, extension) != kVideos.end();
}

namespace {

// Returns whether the name contains `%d`, `%4d` or `%04d` once, because it is later passed to a
// formatting function.
bool IsPrintfPattern(const std::string& pattern) {
  const auto percent = pattern.find('%');
  if (percent == std::string::npos || pattern.find('%', percent + 1) != std::string::npos) {
    return false;
  }
  const auto letter = pattern.find_first_not_of("0123456789", percent + 1);
  return letter != std::string::npos && letter - percent <= 3 && pattern[letter] == 'd';
}

// Returns whether a file's name matches a printf pattern or a glob in a plain folder.
bool NamesAFile(const std::filesystem::path& pattern) {
  const std::string name = pattern.filename().string();
  const auto percent = name.find('%');
  const std::string glob =
      percent == std::string::npos
          ? name
          : name.substr(0, percent) + '*' + name.substr(name.find('d', percent) + 1);
  const auto folder = pattern.has_parent_path() ? pattern.parent_path() : ".";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (fnmatch(glob.c_str(), entry.path().filename().c_str(), 0) == 0) return true;
  }
  return false;
}

void ReadFiles(Section& section, const SceneContext& context, Camera* camera) {
  camera->pattern = ReadImages(section, "file", context);
  camera->source = IsVideo(camera->pattern) ? Camera::Source::kVideo : Camera::Source::kFiles;
}

void ReadSource(Section& section, const SceneContext& context, Camera* camera) {
  if (!NamesOneSource(section)) return;
  if (section.Has("file")) {
    ReadFiles(section, context, camera);
  } else if (section.Has("device")) {
    camera->source = Camera::Source::kDevice;
    camera->device = section.Integer("device");
  } else if (section.Has("url")) {
    camera->source = Camera::Source::kUrl;
    camera->pattern = ReadAddress(section);
  } else {
    camera->source = section.OneOf<Camera::Source>(
        "source", {{"simulated", Camera::Source::kSimulated}, {"stream", Camera::Source::kStream}});
  }
}

// Size without the key. Files and videos have that of their images.
std::array<int, 2> DefaultSize(const Camera& camera) {
  const bool comes_with_images =
      camera.source != Camera::Source::kSimulated && camera.source != Camera::Source::kDevice;
  return comes_with_images ? std::array{0, 0} : camera.size;
}

std::optional<Camera> ReadCamera(Section& sense, const SceneContext& context,
                                 const Eigen::Isometry3d& X_SC) {
  const bool is_needed = context.use == SceneUse::kFull;
  Section section = sense.Open("camera", is_needed ? "a map of source, pixel, ..." : "");
  if (!section.present()) return std::nullopt;
  Camera camera;
  ReadSource(section, context, &camera);
  camera.rate = section.Number("rate");
  camera.size = ReadSize(section, DefaultSize(camera));
  camera.pixel = section.Number("pixel", is_needed ? std::nullopt : std::optional(0.0));
  if (section.Has("distance")) camera.distance = section.Number("distance");
  camera.pixel_tolerance = section.Number("pixel_tolerance");
  camera.X_SC = ReadPlanarPose(section, X_SC);
  camera.lens = ReadExistingFile(section, "intrinsics", context);
  return camera;
}

std::optional<TipTracking> ReadTip(Section& sense, const SceneContext& context) {
  const bool is_needed = context.use == SceneUse::kFull;
  Section section = sense.Open("tip", is_needed ? "a map of track, template, ..." : "");
  if (!section.present()) return std::nullopt;
  TipTracking tip;
  section.OneOf<int>("track", {{"template", 0}}, " in this version");
  tip.template_file = ReadExistingFile(section, "template", context);
  if (section.Has("anchor")) {
    tip.anchor = section.Vector2("anchor");
  }
  tip.anchor_tolerance = section.Number("anchor_tolerance");
  tip.roi = section.Integer("roi");
  return tip;
}

void ReadStart(Section& section, ContourTracking* contour) {
  constexpr const char* kStart = "auto or {polygon: [[x, y], ...]}";
  const DocumentNode* node = section.Has("start") ? section.node()->Find("start") : nullptr;
  if (node == nullptr || node->text == "auto") return;
  if (node->kind != DocumentNode::Kind::kMap) return section.Refuse("start", kStart);
  Section start = section.Open("start");
  if (!start.Has("polygon")) return section.Refuse("start", kStart);
  contour->start = start.Points("polygon");
  if (contour->start.size() < 3) start.Refuse("polygon", "three points [x, y] or more");
}

std::optional<ContourTracking> ReadContour(Section& sense) {
  Section section = sense.Open("contour");
  if (!section.present()) return std::nullopt;
  ContourTracking contour;
  section.OneOf<int>("track", {{"snake", 0}}, " in this version");
  contour.control_points = section.Integer("control_points");
  contour.alpha = section.Number("alpha");
  contour.beta = section.Number("beta");
  contour.gamma = section.Number("gamma");
  ReadStart(section, &contour);
  return contour;
}

// The pose of the depth camera is required: nothing else in the scene determines it.
std::optional<DepthCamera> ReadDepthCamera(Section& sense) {
  Section section = sense.Open("depth_camera");
  if (!section.present()) return std::nullopt;
  DepthCamera camera;
  camera.X_SD = ReadKnownPose(section);
  camera.size = ReadSize(section, camera.size);
  camera.focal = section.Number("focal");
  camera.noise = section.Number("noise");
  return camera;
}

std::optional<SenseChoice> ReadFingertips(Section& sense, const SenseSetting& setting) {
  auto tactile = ReadTactile(sense, setting.context);
  if (!tactile) return std::nullopt;
  for (const char* key : {"camera", "tip", "contour", "points"}) {
    if (sense.Has(key)) {
      sense.Refuse(key, "nothing with `tactile`, because fingertips need no camera");
    }
  }
  return std::move(*tactile);
}

std::optional<SenseChoice> ReadOneCamera(Section& sense, const SenseSetting& setting) {
  if (NamesStereoOrDepth(sense.node())) return std::nullopt;
  if (sense.Has("points")) {
    sense.Refuse("points",
                 "nothing with one camera: points in space need `camera: {source: simulated, pair: "
                 "{}}`, `camera: {stereo: {left, right, rig}}` or `camera: {depth: ...}`");
  }
  CameraOptions options;
  options.camera = ReadCamera(sense, setting.context, setting.X_SC);
  options.tip = ReadTip(sense, setting.context);
  options.contour = ReadContour(sense);
  return options;
}

// One reader for each kind of sensing; nullopt: the scene does not have it. The first kind that the
// scene has is used.
constexpr std::array kSenseReaders{
    &ReadFingertips,
    &ReadStereoOrDepth,
    &ReadOneCamera,
};

}  // namespace

std::array<int, 2> ReadSize(Section& section, const std::array<int, 2>& fallback) {
  if (!section.Has("size")) return fallback;
  const Eigen::Vector2d size = section.Vector2("size", Eigen::Vector2d(0, 0));
  if (size != size.array().floor().matrix()) section.Refuse("size", "whole numbers of pixels");
  return {static_cast<int>(size.x()), static_cast<int>(size.y())};
}

std::string ReadImages(Section& section, std::string_view key, const SceneContext& context) {
  const std::string pattern =
      section.Text(key, "a printf pattern, a glob, a directory or an image file");
  const auto path = context.folder / pattern;
  if (pattern.empty()) return {};
  std::error_code error;
  if (pattern.find('%') != std::string::npos && !IsPrintfPattern(path.filename().string())) {
    section.Refuse(key, "one number such as %d or %04d in the pattern of the file name");
  } else if (context.use != SceneUse::kFull || std::filesystem::is_directory(path, error)) {
    return path.string();
  } else if (pattern.find_first_of("%*?[") == std::string::npos) {
    ReadExistingFile(section, key, context);
  } else if (!NamesAFile(path)) {
    section.Refuse(key, "a pattern that matches a file; none is " + path.string());
  }
  return path.string();
}

std::string ReadAddress(Section& section) {
  constexpr const char* kAccepted =
      "an address such as rtsp://..., http://... or udp://..., or a GStreamer pipeline that ends "
      "in `! appsink`";
  const std::string address = section.Text("url", kAccepted);
  const bool is_pipeline = address.find('!') != std::string::npos;
  const bool is_known = is_pipeline ? address.find("appsink") != std::string::npos
                                    : address.find("://") != std::string::npos;
  if (!address.empty() && !is_known) section.Refuse("url", kAccepted);
  return address;
}

bool NamesOneSource(Section& camera) {
  constexpr std::array kSources{"source", "file", "device", "url", "stereo", "depth"};
  std::string_view named = "source";
  int count = 0;
  for (const char* key : kSources) {
    if (!camera.Has(key)) continue;
    if (count++ == 0) named = key;
  }
  const bool has_pair = camera.Has("pair");
  if (!camera.present()) return false;
  if (count != 1) {
    camera.Refuse(
        named,
        "exactly one of `source: simulated`, `file`, `device`, `stereo` and `depth`, or `url` or "
        "`source: stream`");
  } else if (has_pair && named != "source") {
    camera.Refuse("pair", "nothing with `" + std::string(named) +
                              "`, because it defines two simulated cameras");
  } else {
    return true;
  }
  return false;
}

std::filesystem::path ReadExistingFile(Section& section, std::string_view key,
                                       const SceneContext& context) {
  const std::string name = section.Text(key, "a file", "");
  if (name.empty()) return {};
  auto file = context.folder / name;
  std::error_code error;
  if (context.use == SceneUse::kFull && !std::filesystem::is_regular_file(file, error)) {
    section.Refuse(key, "a file that exists; there is no " + file.string());
  }
  return file;
}

SenseOptions ReadSense(Section& scene, const SenseSetting& setting) {
  const bool is_needed = setting.context.use == SceneUse::kFull;
  Section section = scene.Open(
      "sense", is_needed ? "a map of camera, tip, contour, of camera, points, or of tactile" : "");
  SenseOptions sense;
  for (const auto read : kSenseReaders) {
    auto choice = read(section, setting);
    if (!choice) continue;
    sense.Set(std::move(*choice));
    break;
  }
  sense.depth_camera = ReadDepthCamera(section);
  return sense;
}

}  // namespace palpate
