#include "master/station/replay_scene.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "palpate/v1/teleoperation.pb.h"

#include "master/link/remote_scene.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::ptrdiff_t kSayingsShown = 50;

std::string NewestBy(double t, const std::map<double, std::string>& told) {
  const auto after = told.upper_bound(t);
  return after == told.begin() ? std::string() : std::prev(after)->second;
}

}  // namespace

ReplayScene::ReplayScene(const Replay& replay, const std::string& file) {
  v1::SceneDescription scene;
  v1::Capabilities capabilities;
  const auto since = [&](Time at) { return SecondsBetween(replay.span().first, at); };
  ReplayFeed feed;
  feed.on_scene = [&](const v1::SceneDescription& told, Time at) {
    if (scenes_.empty()) scene = told;
    scenes_[since(at)] = JsonOf(told);
  };
  feed.on_capabilities = [&](const v1::Capabilities& told, Time at) {
    if (capabilities_.empty()) capabilities = told;
    capabilities_[since(at)] = JsonOf(told);
  };
  feed.on_health = [&](const v1::Status& told, Time at) { health_[since(at)] = JsonOf(told); };
  feed.on_log = [&](const std::string& line, Time at, bool is_alarm) {
    entries_.push_back({entries_.size() + 1, since(at), is_alarm, line});
  };
  replay.Play(0, 0, feed, {});
  if (!scenes_.empty()) hello_.scene = ToRemoteScene(scene, capabilities);
  hello_.badge = "REPLAY";
  hello_.target = file;
  TakeNote(replay.span().session);
}

void ReplayScene::TakeNote(const McapMap& session) {
  constexpr std::size_t kLongest = 200;
  const auto take = [&](const char* key, std::string* value) {
    const auto found = session.find(key);
    if (found != session.end()) *value = Presentable(found->second, kLongest);
  };
  std::string limit;
  take("scene", &hello_.scene.name);
  take("device", &hello_.device);
  take("render", &hello_.render);
  take("version", &hello_.version);
  take("force_limit_N", &limit);
  hello_.scene.force_limit = ParseFinite(limit).value_or(hello_.scene.force_limit);
}

std::string ReplayScene::OtherBuild(const std::string& own) const {
  if (hello_.version.empty() || own.empty() || hello_.version == own) return {};
  return "Recorded by palpate-master " + hello_.version + ", played by " + own + ".";
}

SlaveStatusPoller::Words ReplayScene::WordsAt(double t) const {
  return {0, NewestBy(t, scenes_), NewestBy(t, capabilities_), NewestBy(t, health_), {}};
}

std::vector<LogEntry> ReplayScene::SaidBy(double t) const {
  const auto end = std::ranges::upper_bound(entries_, t, {}, &LogEntry::t);
  return {end - std::min(kSayingsShown, end - entries_.begin()), end};
}

}  // namespace palpate
