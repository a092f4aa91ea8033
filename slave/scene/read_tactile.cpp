// `sense.tactile`: fingertips, the source of their samples and their options.
#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "shared/state/slave_state.h"
#include "shared/text/csv.h"
#include "slave/scene/sections.h"

namespace palpate {
namespace {

constexpr std::size_t kMaxNameLength = 32;

void ReadSource(Section& section, const SceneContext& context, Tactile* tactile) {
  constexpr const char* kAccepted = "stream, simulated, or a CSV recording";
  const std::string source = section.Text("source", kAccepted);
  tactile->source = source == "stream"      ? Tactile::Source::kStream
                    : source == "simulated" ? Tactile::Source::kSimulated
                                            : Tactile::Source::kRecording;
  if (tactile->source != Tactile::Source::kRecording || source.empty()) return;
  tactile->file = context.folder / source;
  std::error_code error;
  if (context.use == SceneUse::kFull && !std::filesystem::is_regular_file(tactile->file, error)) {
    section.Refuse("source",
                   std::string(kAccepted) + "; there is no file " + tactile->file.string());
  }
}

// The folder of a network.
std::filesystem::path ReadNetwork(Section& section, const SceneContext& context) {
  const std::string name = section.Text("network", "a folder with network.json", "");
  if (name.empty()) return {};
  auto network = context.folder / name;
  std::error_code error;
  if (context.use == SceneUse::kFull && !std::filesystem::exists(network, error)) {
    section.Refuse("network", "a folder with network.json; there is no " + network.string());
  }
  return network;
}

// Reads `first N`.
int ReadRest(Section& section, int fallback) {
  constexpr std::string_view kFirst = "first ";
  constexpr const char* kAccepted = "`first N`, N from 1 to 10000 samples";
  constexpr long long kMaxCount = 10'000;
  const std::string text =
      section.Text("rest", kAccepted, std::string(kFirst) + std::to_string(fallback));
  const auto count =
      text.starts_with(kFirst) ? ParseInteger(text.substr(kFirst.size())) : std::nullopt;
  if (count && *count >= 1 && *count <= kMaxCount) return static_cast<int>(*count);
  section.Refuse("rest", kAccepted);
  return fallback;
}

void RequireName(const Section& section, std::string_view key, std::string_view name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  if (!name.empty() && name.size() <= kMaxNameLength && std::ranges::all_of(name, is_plain)) return;
  section.mistakes()->Add(*section.node()->Find(key), section.PathOf(key),
                          "a finger's name of 1 to 32 letters, digits, _ or -");
}

Eigen::Isometry3d ReadFingerPose(Section& section, Finger* finger) {
  finger->has_pose = section.Has("pose");
  return ReadPose(section, finger->X_SF);
}

Finger ReadFinger(Section& fingers, const DocumentNode& node, bool is_first) {
  RequireName(fingers, node.key, node.key);
  Section section = fingers.Open(node.key);
  Finger finger;
  finger.name = node.key;
  finger.X_SF = ReadFingerPose(section, &finger);
  finger.motion = section.OneOf<Finger::Motion>("motion", {{"hand", Finger::Motion::kHand},
                                                           {"opposite", Finger::Motion::kOpposite},
                                                           {"stands", Finger::Motion::kAtRest}});
  if (is_first && finger.motion != Finger::Motion::kHand) {
    section.Refuse("motion", "hand for the first finger, which the operator moves");
  }
  return finger;
}

// `fingers`, a map of name to {pose, motion}.
std::vector<Finger> ReadFingers(Section& tactile) {
  constexpr const char* kAccepted = "a map of 1 to 5 fingers, `name: {pose: {...}, motion: hand}`";
  for (const char* key : {"finger", "pose"}) {
    if (tactile.Has(key))
      tactile.Refuse(key, "nothing with `fingers`, which define it for each finger");
  }
  Section fingers = tactile.Open("fingers");
  std::vector<Finger> read;
  if (!fingers.present()) return read;
  for (const DocumentNode& node : fingers.node()->children) {
    read.push_back(ReadFinger(fingers, node, read.empty()));
  }
  if (read.empty() || read.size() > kMaxFingers) tactile.Refuse("fingers", kAccepted);
  return read;
}

// Reads the keys `finger` and `pose` of the only finger.
Finger ReadOnlyFinger(Section& tactile) {
  Finger finger;
  finger.name = tactile.Text("finger", "a finger's name", "finger");
  if (tactile.Has("finger")) RequireName(tactile, "finger", finger.name);
  finger.X_SF = ReadFingerPose(tactile, &finger);
  return finger;
}

void ReadMeasures(Section& section, Tactile* tactile) {
  tactile->rate = section.Number("rate");
  tactile->finger_radius = section.Number("radius");
  tactile->pose_tolerance = section.Number("pose_tolerance");
  tactile->patch = section.Number("patch");
}

TactileChannels ReadChannels(Section& section, Tactile::Source source) {
  constexpr std::size_t kMaxUnitLength = 16;
  TactileChannels channels;
  channels.count = section.Integer("channels");
  channels.unit = section.Text("unit");
  if (channels.unit.empty() || channels.unit.size() > kMaxUnitLength) {
    section.Refuse("unit", "the unit of the channels, 1 to 16 characters");
  }
  if (!channels.are_electrodes() && source == Tactile::Source::kSimulated) {
    section.Refuse("channels", "19 in counts: the simulated fingertips have 19 electrodes");
  }
  return channels;
}

// Returns whether the recording has the pose of a fingertip in each row: a column `qw` or
// `NAME_qw`.
bool HasPoseColumns(const Tactile& tactile) {
  if (tactile.source != Tactile::Source::kRecording) return false;
  const auto is_pose = [](std::string_view title) {
    return title == "qw" || title.ends_with("_qw");
  };
  try {
    CsvLines lines(tactile.file);
    return lines.Next() && std::ranges::any_of(lines.cells(), is_pose);
  } catch (const std::runtime_error&) {  // a missing or invalid file is reported by its reader
    return false;
  }
}

void ReadWays(Section& section, Tactile* tactile) {
  tactile->hold = section.OneOf<Tactile::Hold>(
      "hold", {{"force", Tactile::Hold::kForce}, {"displacement", Tactile::Hold::kDisplacement}});
}

}  // namespace

std::optional<Tactile> ReadTactile(Section& sense, const SceneContext& context) {
  Section section = sense.Open("tactile");
  if (!section.present()) return std::nullopt;
  Tactile tactile;
  ReadSource(section, context, &tactile);
  if (section.Has("fingers")) {
    tactile.fingers = ReadFingers(section);
  } else {
    tactile.fingers = {ReadOnlyFinger(section)};
  }
  if (tactile.fingers.empty()) tactile.fingers.emplace_back();  // after a mistake
  tactile.network = ReadNetwork(section, context);
  tactile.rest_samples = ReadRest(section, tactile.rest_samples);
  tactile.channels = ReadChannels(section, tactile.source);
  tactile.electrodes = ReadExistingFile(section, "electrodes", context);
  ReadMeasures(section, &tactile);
  ReadWays(section, &tactile);
  tactile.has_recorded_poses = HasPoseColumns(tactile);
  return tactile;
}

}  // namespace palpate
