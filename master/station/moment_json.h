// The station's text messages, as the page reads them (page/link.js). SI; what is not known is
// null.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "master/doctor/finding.h"
#include "master/haptics/session.h"
#include "master/link/remote_mesh.h"
#include "master/link/remote_scene.h"
#include "master/link/slave_status_poller.h"
#include "master/station/hand_trace.h"
#include "master/station/tick_digest.h"

namespace palpate {

// What does not change while the session lasts.
struct StationHello {
  RemoteScene scene;
  std::string target, device, render, version;
  bool encrypted = false;  // the line to the slave
  bool pointer = false;    // the page's own pointer moves the hand
  bool libraries = false;  // what draws 3D and charts was built in
  std::string badge = "LIVE";
  std::optional<double> certificate_until;  // ours holds so long, since 1970 [s]; nothing: no TLS
};
std::string HelloJson(const StationHello& hello);

// Of a recording that is played.
struct ReplayMoment {
  bool playing = true;
  double speed = 1;       // times as fast as it was
  double seconds = 0;     // its length [s]
  std::uint64_t run = 0;  // rises where it goes on elsewhere
};

// Of the recording that a session makes.
struct RecordingMoment {
  bool on = false;
  double megabytes = 0;
  std::string trouble;              // why it ended, or what is missing
  std::optional<double> room = {};  // what its disk has left [MB]; nothing: not known
};

// Everything that moves, at one moment.
struct StationMoment {
  TickDigest::Moment ticks;
  Status status;                          // of the session's slow thread
  SlaveStatusPoller::ObservedState felt;  // as an observer sees it
  bool pointer_holds = false;
  double pointer_used = 0;    // stamp of the page's aim that moved the hand last; 0: none
  double picture_stands = 0;  // so long the picture has stood still [s]; 0: it goes on, or none is
  std::string video_trouble, mesh_trouble;
  std::vector<std::string> slave_alarms;     // as the slave's health tells them
  std::string health_trouble;                // why it is not told
  std::optional<RecordingMoment> recording;  // nothing: none can be made
  std::optional<ReplayMoment> replay;        // nothing: this is live
  std::string other_release;                 // see OtherRelease
  std::optional<HandTrace> trace;            // of a recent tick; nothing: it is not told
  SlaveLink::Mapping waiting;                // asked for, until nobody feels the change
  double felt_age = 0;                       // since `felt` came [s]
};
// What the slave told a quarter second ago and more is no longer so: the force is unknown, stale.
void LeaveOutOld(StationMoment* moment);
std::string StatusJson(const StationMoment& moment);

// Of an examination, the bad first; one that goes on has found nothing yet.
std::string FindingsJson(const Findings& findings, bool is_done);

// The slave's own words; of its health what is wrong.
std::string HealthJson(const SlaveStatusPoller::Words& words);
std::vector<std::string> AlarmsIn(const SlaveStatusPoller::Words& words);

// What happened, the newest last.
struct LogEntry {
  std::uint64_t number = 0;  // rises by one
  double t = 0;              // [s] since the run began
  bool is_trouble = false;
  std::string text;
};
std::string SaidJson(const std::vector<LogEntry>& entries);

// The answers to a page: that it was heard, at the page's own `at`; why something is not done.
std::string PongJson(double at);
// `run`: of a replay, as its moment tells it.
std::string PastJson(const std::vector<TickSample>& samples, std::optional<std::uint64_t> run = {});
std::string RefusedJson(const std::string& why);
// It held the hand, which another page leads, or led then: it has to let go.
std::string LedElsewhereJson();

// Node and element counts, places at rest, elements, nodes that are held: what Topology messages
// hold after the header.
std::string TopologyBytes(const MeshTopology& topology);
// Validity as a number (0: valid), then the places; where the traction is told its unit [Pa] and a
// byte of steps per node.
std::string ShapeBytes(const RemoteMesh& mesh);

}  // namespace palpate
