// JSON messages for the page (page/link.js), in SI units. Unknown values are null. Messages of the
// slave and the tick (ForceTick of recording.proto) are printed once, with the names of proto.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpate/v1/state.pb.h"

#include "master/link/observer.h"
#include "master/link/remote_mesh.h"
#include "master/link/remote_scene.h"
#include "master/session/session.h"
#include "master/station/tick_digest.h"

namespace palpate {

// Constants of a session.
struct StationHello {
  RemoteScene scene;
  std::string target, device, render, version;
  bool encrypted = false;      // the link to the slave
  bool pointer = false;        // the page's pointer is the device
  bool only_observes = false;  // the master has no device
  bool libraries = false;      // three.js and uPlot are built in
  std::string badge = "LIVE";
  std::optional<double>
      certificate_until;  // expiry of the master's certificate since 1970 [s]; empty: no TLS
};
std::string HelloJson(const StationHello& hello);

// State of a replay.
struct ReplayMoment {
  bool playing = true;
  double speed = 1;       // relative to real time
  double seconds = 0;     // its length [s]
  std::uint64_t run = 0;  // rises at each jump
};

// State of the recording of a session.
struct RecordingMoment {
  bool on = false;
  double megabytes = 0;
  std::string trouble;              // why it ended, or that it falls behind; empty: neither
  bool falls_behind = false;        // `trouble` is that it falls behind
  std::optional<double> room = {};  // free disk space [MB]; empty: unknown
};

// Data of one status message.
struct StationMoment {
  TickDigest::Moment ticks;
  SessionStatus status;        // from the session's slow thread
  v1::SlaveState slave_state;  // the newest, as received; `sequence` 0: none yet
  bool pointer_holds = false;
  double pointer_used = 0;     // stamp of the last applied target of the page; 0: none
  double pointer_silence = 0;  // see Pointer::silence [s]
  double frozen_for = 0;       // time since the image is frozen [s]; 0: not frozen, or no image
  std::string video_trouble, mesh_trouble;
  std::vector<std::string> slave_alarms;     // of the slave's status
  std::string health_trouble;                // why no status is received
  std::optional<RecordingMoment> recording;  // empty: no recording
  std::optional<ReplayMoment> replay;        // empty: live
  std::string other_release;                 // see OtherRelease
  std::optional<HandTrace> trace;            // of a recent tick; empty: unknown
  SlaveLink::Mapping waiting;  // requested values that wait until disengaged and without contact
  double slave_state_age = 0;  // time since `slave_state` was received [s]
};
// Marks the force as unknown and stale if `slave_state` is older than a quarter of a second.
void LeaveOutOld(StationMoment* moment);
std::string StatusJson(const StationMoment& moment);

// Messages of the slave as JSON; and the alarms in its status, at most eight.
std::string HealthJson(const SlaveHealth& health);
std::vector<std::string> AlarmsIn(const SlaveHealth& health);

// An event. Lists have the newest last.
struct LogEntry {
  std::uint64_t number = 0;  // rises by one
  double t = 0;              // [s] since the run began
  bool is_trouble = false;
  std::string text;
};
std::string LogJson(const std::vector<LogEntry>& entries);

// Answers to a page: to a ping with its `at`, past samples, and the reason of a rejection.
std::string PongJson(double at);
// `run`: see ReplayMoment.
std::string PastJson(const std::vector<TickSample>& samples, std::optional<std::uint64_t> run = {});
std::string RefusedJson(const std::string& why);
// Another page controls the pointer, so this page must disengage.
std::string LedElsewhereJson();

// Content of Topology messages after the header: node and element counts, rest positions, elements,
// fixed nodes.
std::string TopologyBytes(const MeshTopology& topology);
// Content of Shape messages after the header: validity as a number (0: valid), positions, and the
// traction at each node [Pa] if known.
std::string ShapeBytes(const RemoteMesh& mesh);
// Content of FieldTopology messages after the header: node and triangle counts, rest positions x,
// y, z per node in frame O [m] as float32, node indices of the triangles, three each, as uint32.
std::string FieldTopologyBytes(const MeshTopology& topology);
// Content of Field messages after the header, for the image of the same time: validity as a number
// (0: valid); 1, or 0 without a camera; per node the displacement x, y, z in frame O [m], then with
// a camera the displaced position u, v in the image [px], as float32. See DisplacementField of
// state.proto.
std::string FieldBytes(const RemoteMesh& mesh);

}  // namespace palpate
