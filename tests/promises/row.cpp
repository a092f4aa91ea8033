#include "tests/promises/row.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

namespace YAML {

template <>
struct convert<Eigen::Vector2d> {
  static bool decode(const Node& node, Eigen::Vector2d& v) {
    if (!node.IsSequence() || node.size() != 2) return false;
    v = {node[0].as<double>(), node[1].as<double>()};
    return true;
  }
};
template <>
struct convert<Eigen::Vector3d> {
  static bool decode(const Node& node, Eigen::Vector3d& v) {
    if (!node.IsSequence() || node.size() != 3) return false;
    v = {node[0].as<double>(), node[1].as<double>(), node[2].as<double>()};
    return true;
  }
};

}  // namespace YAML

namespace palpate::promises {
namespace {

// A map of which each key must be read.
class Keys {
 public:
  Keys(const YAML::Node& node, std::string where) : node_(node), where_(std::move(where)) {}

  template <typename T>
  void Read(const char* key, T* value) {
    known_.insert(key);
    if (node_[key]) *value = As<T>(key);
  }
  template <typename T>
  void Read(const char* key, std::optional<T>* value) {
    known_.insert(key);
    if (node_[key]) *value = As<T>(key);
  }
  void Finish() const {
    for (const auto& item : node_) {
      const auto key = item.first.as<std::string>();
      if (!known_.contains(key)) throw std::invalid_argument(where_ + ": unknown key " + key);
    }
  }

 private:
  template <typename T>
  [[nodiscard]] T As(const char* key) const try {
    return node_[key].as<T>();
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(where_ + "." + key + ": " + error.what());
  }

  YAML::Node node_;
  std::string where_;
  std::set<std::string> known_;
};

Disturbance ReadEvent(const YAML::Node& node, const std::string& where) {
  Disturbance event;
  Keys keys(node, where);
  keys.Read("at", &event.at);
  keys.Read("side", &event.side);
  keys.Read("shift_px", &event.shift_px);
  keys.Read("grow", &event.grow);
  keys.Read("light", &event.light);
  keys.Read("blur_px", &event.blur_px);
  keys.Read("noise", &event.noise);
  keys.Read("cover", &event.cover);
  keys.Read("late", &event.late);
  keys.Read("exchanged", &event.exchanged);
  keys.Read("delay_s", &event.delay_s);
  keys.Read("frozen", &event.frozen);
  keys.Read("silent", &event.silent);
  keys.Read("channel", &event.channel);
  keys.Read("value", &event.value);
  keys.Read("add", &event.add);
  keys.Read("most", &event.most);
  keys.Read("stuck", &event.stuck);
  keys.Read("absent", &event.absent);
  keys.Read("poses", &event.poses);
  keys.Read("encoders_m", &event.encoders_m);
  keys.Read("encoders_scale", &event.encoders_scale);
  keys.Read("driver", &event.driver);
  keys.Read("reconnects", &event.reconnects);
  keys.Read("reset", &event.reset);
  keys.Read("operates", &event.operates);
  keys.Read("pause_s", &event.pause_s);
  keys.Read("command_m", &event.command_m);
  keys.Read("device_m_s", &event.device_m_s);
  keys.Read("resent", &event.resent);
  keys.Read("watch_every", &event.watch_every);
  keys.Read("stop", &event.stop);
  keys.Read("reset_of", &event.reset_of);
  keys.Finish();
  return event;
}

Expectation ReadExpectation(const YAML::Node& node, const std::string& where) {
  Expectation expected;
  Keys keys(node, where);
  keys.Read("from", &expected.from);
  keys.Read("to", &expected.to);
  keys.Read("check", &expected.check);
  keys.Read("validity", &expected.validity);
  keys.Read("share", &expected.share);
  keys.Read("never", &expected.never);
  keys.Read("force", &expected.force);
  keys.Read("force_error", &expected.force_error);
  keys.Read("force_peak", &expected.force_peak);
  keys.Read("tip_error_m", &expected.tip_error_m);
  keys.Read("tip_travel_m", &expected.tip_travel_m);
  keys.Read("guards", &expected.guards);
  keys.Read("depth_m", &expected.depth_m);
  keys.Read("off_target_m", &expected.off_target_m);
  keys.Read("age_s", &expected.age_s);
  keys.Read("sigma", &expected.sigma);
  keys.Read("error_by_sigma", &expected.error_by_sigma);
  keys.Read("event", &expected.event);
  keys.Read("phase", &expected.phase);
  keys.Read("alarm", &expected.alarm);
  keys.Read("alarms", &expected.alarms);
  keys.Finish();
  return expected;
}

Row ReadRow(const YAML::Node& node, const std::string& scene) {
  Row row;
  Keys keys(node, node["name"] ? node["name"].as<std::string>() : "a row without a name");
  std::string page;
  YAML::Node events, expected, scenes;
  keys.Read("name", &row.name);
  keys.Read("page", &page);
  keys.Read("promise", &row.promise);
  keys.Read("scene", &scenes);
  keys.Read("site", &row.site);
  keys.Read("stated", &row.stated);
  keys.Read("blind", &row.is_blind);
  keys.Read("full", &row.is_full);
  keys.Read("follows_s", &row.follows_s);
  keys.Read("events", &events);
  keys.Read("expected", &expected);
  keys.Finish();
  row.page = page;
  row.scene = scene;
  if (scenes.IsSequence()) row.name += "_" + row.scene.stem().string();
  std::ranges::replace(row.name, '-', '_');
  for (const auto& event : events) row.events.push_back(ReadEvent(event, row.name + ".events"));
  for (const auto& one : expected) {
    row.expected.push_back(ReadExpectation(one, row.name + ".expected"));
  }
  if (row.name.empty() || row.promise.empty() || row.expected.empty()) {
    throw std::invalid_argument(row.name + ": expected name, promise and expected");
  }
  return row;
}

}  // namespace

std::vector<Row> ReadRows(const std::filesystem::path& file) {
  std::vector<Row> rows;
  for (const auto& node : YAML::LoadFile(file.string())) {
    const YAML::Node scenes = node["scene"];
    if (scenes.IsScalar()) rows.push_back(ReadRow(node, scenes.as<std::string>()));
    for (const auto& scene : scenes) rows.push_back(ReadRow(node, scene.as<std::string>()));
  }
  return rows;
}

}  // namespace palpate::promises
