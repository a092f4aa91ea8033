// `sense.camera` for a pair of cameras, simulated or from files, or for depth images (paper C).
#include <algorithm>
#include <array>
#include <cmath>

#include "slave/scene/sections.h"

namespace palpate {
namespace {

constexpr double kDistance = 0.25;  // of a simulated pair from the object [m]: paper C, 5.1

// Returns the pose of the left one of two cameras that are side by side along x of O and look at
// O's origin.
Eigen::Isometry3d LeftOfPair(const Eigen::Isometry3d& X_SO, double baseline) {
  const double vergence = std::atan2(0.5 * baseline, kDistance);
  return X_SO * Eigen::Translation3d(-0.5 * baseline, 0, -kDistance) *
         Eigen::AngleAxisd(vergence, Eigen::Vector3d::UnitY());
}

StereoCameras ReadSimulated(Section& camera, const Object& object) {
  StereoCameras pair;
  camera.OneOf<int>("source", {{"simulated", 0}});
  pair.size = ReadSize(camera, pair.size);
  constexpr int kMaxPainted = 8192;  // edge [px]
  if (std::max(pair.size[0], pair.size[1]) > kMaxPainted) {
    camera.Refuse("size", "[width, height], 16 to 8192 px each with a simulated pair");
  }
  Section section = camera.Open("pair");
  pair.focal = section.Number("focal");
  pair.baseline = section.Number("baseline");
  pair.X_SL = ReadPose(camera, LeftOfPair(object.X_SO, pair.baseline));
  return pair;
}

std::string FirstLine(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

// Reads only the part of the rig's file that is needed to reject a wrong file and to find the size
// of the left images; {0, 0}: unknown.
std::array<int, 2> ReadRigHeader(Section& section, const StereoCameras& pair) {
  constexpr const char* kAccepted =
      "a rig of two cameras, written by `calibrate --left ... --right ...`";
  Mistakes mistakes(pair.rig);
  const DocumentNode rig = ReadDocument(pair.rig, {}, &mistakes);
  const DocumentNode* left = rig.Find("left");
  if (mistakes.count() > 0) {
    section.Refuse("rig", std::string(kAccepted) + "; " + FirstLine(mistakes.text()));
  } else if (left == nullptr || rig.Find("right") == nullptr) {
    section.Refuse("rig", std::string(kAccepted) + "; this one has no `" +
                              (left == nullptr ? "left" : "right") + "`");
  } else {
    const auto edge = [&](const char* key) {
      const DocumentNode* node = left->Find(key);
      const auto pixels = node == nullptr ? std::nullopt : ParseInteger(node->text);
      return pixels && *pixels > 0 && *pixels <= kMaxImage ? static_cast<int>(*pixels) : 0;
    };
    return {edge("image_width"), edge("image_height")};
  }
  return {0, 0};
}

bool IsMap(const Section& section, std::string_view key) {
  const DocumentNode* node = section.node() == nullptr ? nullptr : section.node()->Find(key);
  return node != nullptr && node->kind == DocumentNode::Kind::kMap;
}

// Formats that OpenCV reads with 16 bit; it reduces all others to 8 bit.
std::string ReadDepthPipeline(Section& section) {
  constexpr const char* kAccepted =
      "a GStreamer pipeline that ends in `! video/x-raw,format=GRAY16_LE ! appsink`, because other "
      "streams and videos have 8 bit";
  const std::string pipeline = section.Text("url", kAccepted);
  const auto has = [&](const char* part) { return pipeline.find(part) != std::string::npos; };
  if (!has("!") || !has("GRAY16_LE") || !has("appsink")) section.Refuse("url", kAccepted);
  return pipeline;
}

// One of `device`, `file` and `url` below `section`, for depth images only `url`; refused if none
// or several are given.
Eye ReadCameraSource(Section& section, const SceneContext& context, bool is_depth) {
  constexpr std::array kKeys{"device", "file", "url"};
  const auto has = [&](const char* key) { return section.Has(key); };
  const auto named = std::ranges::count_if(kKeys, has);
  const bool is_wrong_kind = is_depth && !has("url");
  Eye source;
  if (named != 1 || is_wrong_kind) {
    const auto key = std::ranges::find_if(kKeys, has);
    section.Refuse(key == kKeys.end() ? "device" : *key,
                   is_depth ? "`url`, a GStreamer pipeline, or `source: stream`"
                            : "exactly one of `device: NUMBER`, `file` (a video) and `url`");
  } else if (section.Has("url")) {
    source = {Eye::Kind::kUrl, 0, is_depth ? ReadDepthPipeline(section) : ReadAddress(section)};
  } else if (section.Has("file")) {
    source = {Eye::Kind::kVideo, 0, ReadExistingFile(section, "file", context).string()};
  } else {
    source.device = section.Integer("device");
  }
  return source;
}

bool IsSame(const Eye& a, const Eye& b) {
  return a.kind == b.kind && a.device == b.device && a.address == b.address;
}

// Two cameras, or one with both images side by side.
void ReadCamerasOfPair(Section& section, const SceneContext& context, StereoCameras* pair) {
  pair->source = StereoCameras::Source::kCameras;
  if (!section.Has("layout")) {
    for (const char* key : {"left", "right"}) {
      Section one = section.Open(key, "a map of `device: NUMBER`, `file` (a video) or `url`");
      if (one.present()) pair->cameras.push_back(ReadCameraSource(one, context, false));
    }
    const auto is_video = [](const Eye& eye) { return eye.kind == Eye::Kind::kVideo; };
    const auto videos = std::ranges::count_if(pair->cameras, is_video);
    if (videos == 1) section.Refuse("left", "two videos, or two cameras or streams");
    if (pair->cameras.size() == 2 && IsSame(pair->cameras[0], pair->cameras[1])) {
      section.Refuse(
          "right", "another camera than `left`; for both in one image use `layout: side-by-side`");
    }
    return;
  }
  section.OneOf<int>("layout", {{"side-by-side", 0}});
  pair->cameras.push_back(ReadCameraSource(section, context, false));
}

void ReadPairSource(Section& section, const SceneContext& context, StereoCameras* pair) {
  const bool is_live = section.Has("source") || section.Has("layout") || IsMap(section, "left");
  if (section.Has("source")) {
    section.OneOf<int>("source", {{"stream", 0}});
    pair->source = StereoCameras::Source::kStream;
  } else if (is_live) {
    ReadCamerasOfPair(section, context, pair);
  } else {
    pair->source = StereoCameras::Source::kFiles;
    pair->left = ReadImages(section, "left", context);
    pair->right = ReadImages(section, "right", context);
  }
  if (!section.Has("sync")) return;
  pair->sync = section.Number("sync");
  if (!is_live) section.Refuse("sync", "nothing with files, because their names pair them");
}

StereoCameras ReadStereoFiles(Section& camera, const SceneContext& context, const Object& object) {
  const bool is_full = context.use == SceneUse::kFull;
  StereoCameras pair;
  pair.size = {0, 0};
  Section section = camera.Open("stereo");
  ReadPairSource(section, context, &pair);
  const std::size_t before = section.mistakes()->count();
  if (is_full && !section.Has("rig")) {
    section.Refuse("rig", "a file that `calibrate` wrote");
  } else {
    pair.rig = ReadExistingFile(section, "rig", context);
  }
  if (is_full && section.mistakes()->count() == before) pair.size = ReadRigHeader(section, pair);
  // An object that is only tracked may be tracked in the left camera's frame.
  const bool needs_pose = is_full && IsHeld(object);
  pair.X_SL = needs_pose ? ReadKnownPose(camera) : ReadPose(camera, pair.X_SL);
  return pair;
}

void ReadDepthSource(Section& camera, const SceneContext& context, DepthImages* depth) {
  if (!IsMap(camera, "depth")) {
    depth->pattern = ReadImages(camera, "depth", context);
    return;
  }
  Section section = camera.Open("depth");
  if (section.Has("source")) {
    section.OneOf<int>("source", {{"stream", 0}});
    depth->source = DepthImages::Source::kStream;
  } else {
    depth->source = DepthImages::Source::kEye;
    depth->eye = ReadCameraSource(section, context, true);
  }
}

DepthImages ReadDepthImages(Section& camera, const SceneContext& context) {
  DepthImages depth;
  ReadDepthSource(camera, context, &depth);
  depth.unit = camera.Number("unit");
  depth.fx = camera.Number("fx");
  depth.fy = camera.Number("fy");
  depth.cx = camera.Number("cx");
  depth.cy = camera.Number("cy");
  depth.sigma = camera.Number("sigma");
  depth.X_SD =
      context.use == SceneUse::kFull ? ReadKnownPose(camera) : ReadPose(camera, depth.X_SD);
  return depth;
}

// Skips the other keys after a mistake.
void PassOver(Section& camera) {
  for (const char* key :
       {"rate", "size", "pose", "pixel", "intrinsics", "unit", "fx", "fy", "cx", "cy", "sigma"}) {
    camera.Has(key);
  }
}

}  // namespace

bool NamesStereoOrDepth(const DocumentNode* sense) {
  const DocumentNode* camera = sense == nullptr ? nullptr : sense->Find("camera");
  if (camera == nullptr) return false;
  const auto has = [&](const char* key) { return camera->Find(key) != nullptr; };
  return has("pair") || has("stereo") || has("depth");
}

std::optional<SenseChoice> ReadStereoOrDepth(Section& sense, const SenseSetting& setting) {
  if (!NamesStereoOrDepth(sense.node())) return std::nullopt;
  for (const char* key : {"tip", "contour"}) {
    if (sense.Has(key)) {
      sense.Refuse(key,
                   "nothing with a stereo pair or depth camera: `points` defines what is tracked");
    }
  }
  Section camera = sense.Open("camera");
  if (!NamesOneSource(camera)) {
    PassOver(camera);
    sense.Has("points");
    return std::nullopt;
  }
  const double rate = camera.Number("rate", StereoCameras().rate);
  if (camera.Has("pixel")) {
    camera.Refuse("pixel", "nothing here: the focal length defines the scale");
  }
  PointsOptions options;
  if (camera.Has("depth")) {
    options.cameras = ReadDepthImages(camera, setting.context);
  } else {
    options.cameras = camera.Has("stereo")
                          ? ReadStereoFiles(camera, setting.context, setting.object)
                          : ReadSimulated(camera, setting.object);
  }
  std::visit([&](auto& cameras) { cameras.rate = rate; }, options.cameras);
  options.points = ReadPoints(sense, setting, options.cameras);
  return options;
}

}  // namespace palpate
