// Tests SlaveLink with a real gRPC server of a fake slave.
#include "master/link/slave_link.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/operator_calls.h"
#include "shared/link/datagram_line.h"
#include "shared/link/loopback.h"
#include "shared/link/tcp_line.h"
#include "shared/wire/errors.h"
#include "shared/wire/fields.h"
#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using testing::HasSubstr;

// Replaces the haptic loop: puts commands and takes states 1000 times per second.
class Loop {
 public:
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  OperatorCommand command;
  bool rejects_states = false;
  ReceivedState newest;

  template <class Condition>
  bool Until(const Condition& condition) {
    return Eventually([&] {
      if (condition()) return true;
      ++command.sequence;
      commands.Put(command);
      if (const ReceivedState* taken = states.Take()) {
        newest = *taken;
        if (rejects_states) return false;
        command.state_sequence = newest.state.sequence;
        command.echo = newest.state.sent_at;
      }
      return false;
    });
  }
};

// A link that has begun.
struct StartedLink : SlaveLink {
  StartedLink(const Options& options, Loop& loop) : SlaveLink(options) {
    Start(&loop.states, &loop.commands, &loop.settings, true);
  }
};

class SlaveLinkTest : public testing::Test {
 protected:
  SlaveLink::Options To(const std::string& target) const {
    SlaveLink::Options options;
    options.target = target;
    options.operator_name = "Ada";
    return options;
  }

  FakeSlave slave_;
  std::unique_ptr<Server> server_ = std::make_unique<Server>(slave_, "127.0.0.1:0", false);
  Loop loop_;
};

// Reference: the fake's spring: 2 mm below the surface at 1000 N/m.
TEST_F(SlaveLinkTest, CommandsArriveAndTheForceComesBack) {
  StartedLink link(To(server_->address()), loop_);
  loop_.command.epoch = 1;
  loop_.command.engaged = true;
  ASSERT_TRUE(loop_.Until([&] { return loop_.newest.state.phase == Phase::kFollowing; }));
  loop_.command.p_M = {0, -8e-3, 0};
  ASSERT_TRUE(loop_.Until([&] { return loop_.newest.state.p_S_tip.y() < -1e-3; }));
  slave_.TakeSample();
  ASSERT_TRUE(loop_.Until(
      [&] { return loop_.newest.state.force.value_or(Eigen::Vector3d::Zero()).y() > 0; }));
  EXPECT_NEAR(loop_.newest.state.force->y(), 2, 1e-9);
  EXPECT_EQ(loop_.newest.state.local_model.stiffness(1, 1), FakeSlave::kStiffness);
  link.Stop();
  EXPECT_EQ(slave_.ends(), 1);
}

// Reference: the fake's results of checks. A page of the operator opens no second stream for them.
TEST_F(SlaveLinkTest, DetailsComeWithTheOperatorsStream) {
  for (const bool requested : {false, true}) {
    SlaveLink::Options options = To(server_->address());
    options.details = requested;
    StartedLink link(options, loop_);
    ASSERT_TRUE(loop_.Until([&] {
      const StateRecord newest = link.state();
      return newest.message && newest.message->command_sequence() > 0 &&
             newest.message->has_details() == requested;
    }));
    const StateRecord newest = link.state();
    EXPECT_EQ(newest.message->details().score(), requested ? 0.75F : 0);
    EXPECT_EQ(newest.message->has_moment(), requested);
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    const auto stub = v1::Teleoperation::NewStub(grpc::CreateCustomChannel(
        server_->address(), grpc::InsecureChannelCredentials(), arguments));
    grpc::ClientContext context;
    v1::Status status;
    ASSERT_TRUE(stub->GetStatus(&context, {}, &status).ok());
    EXPECT_EQ(status.observers(), 0U);
    link.Stop();
  }
}

TEST_F(SlaveLinkTest, EventsAreReportedOnce) {
  StartedLink link(To(server_->address()), loop_);
  ASSERT_TRUE(loop_.Until([&] { return link.stats().connected; }));
  slave_.Happen(Event::kPuncture);
  Events events;
  ASSERT_TRUE(loop_.Until([&] {
    events.Add(link.TakeEvents());
    return events.Has(Event::kPuncture);
  }));
  EXPECT_FALSE(link.TakeEvents().Has(Event::kPuncture));
}

TEST_F(SlaveLinkTest, WhoWaitsForTheLeaseReceivesTheStatesMeanwhile) {
  auto first = std::make_unique<StartedLink>(To(server_->address()), loop_);
  ASSERT_TRUE(loop_.Until([&] { return first->stats().connected; }));
  SlaveLink::Options options = To(server_->address());
  options.operator_name = "Grace";
  Loop other;
  StartedLink second(options, other);
  std::uint64_t seen = 0;
  ASSERT_TRUE(loop_.Until([&] {
    const StateRecord newest = second.state();
    if (newest.message) seen = newest.message->sequence();
    return seen > 5;
  }));
  EXPECT_FALSE(second.stats().connected);
  // The second may ask before the name of the first has arrived.
  EXPECT_TRUE(other.Until([&] { return second.stats().trouble.find("Ada") != std::string::npos; }));
  EXPECT_TRUE(other.Until([&] { return other.newest.observed; }))
      << "the loop renders no force of another operator";
  first.reset();
  ASSERT_TRUE(other.Until([&] { return second.stats().connected; }));
}

// The slave holds the tool when the operator has used no newer state for 100 ms.
TEST_F(SlaveLinkTest, StatesThatTheLoopRejectsAreNotReportedAsUsed) {
  loop_.rejects_states = true;
  StartedLink link(To(server_->address()), loop_);
  ASSERT_TRUE(loop_.Until(
      [&] { return loop_.newest.state.sequence > 3 && slave_.commands().size() > 20; }));
  EXPECT_EQ(slave_.commands().back().state_sequence, 0U);
  EXPECT_FALSE(slave_.commands().back().echo.has_value());
}

// The slave must notice that a loop does not renew its command: the link does not repeat it.
TEST_F(SlaveLinkTest, ACommandThatIsNotRenewedIsNotRepeated) {
  StartedLink link(To(server_->address()), loop_);
  ASSERT_TRUE(loop_.Until([&] { return link.stats().commands > 5; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const std::uint64_t sent = link.stats().commands;
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_LE(link.stats().commands, sent + 1);
}

TEST_F(SlaveLinkTest, AfterTheSlaveCameBackTheLinkIsThereAgain) {
  const std::string address = server_->address();
  StartedLink link(To(address), loop_);
  ASSERT_TRUE(loop_.Until([&] { return link.stats().connected; }));
  server_.reset();
  ASSERT_TRUE(loop_.Until([&] { return !link.stats().connected; }));
  EXPECT_THAT(link.stats().trouble, testing::Not(testing::IsEmpty()));
  FakeSlave next;
  server_ = std::make_unique<Server>(next, address, false);
  ASSERT_TRUE(loop_.Until([&] { return link.stats().connected; }));
  EXPECT_EQ(link.stats().reconnects, 1U);
  EXPECT_EQ(link.stats().trouble, "");
  ASSERT_TRUE(loop_.Until([&] { return !next.commands().empty(); }));
  EXPECT_GT(next.commands().front().sequence, 1U) << "the loop goes on counting";
  link.Stop();
  server_.reset();
}

TEST_F(SlaveLinkTest, TheEmergencyStopReachesTheSlaveBesideTheStream) {
  StartedLink link(To(server_->address()), loop_);
  ASSERT_TRUE(loop_.Until([&] { return link.stats().connected; }));
  EXPECT_TRUE(link.calls().EmergencyStop("the hand let go"));
  EXPECT_EQ(slave_.stop_reason(), "the hand let go");
  EXPECT_TRUE(loop_.Until([&] { return loop_.newest.state.phase == Phase::kEstop; }));
  server_.reset();
  EXPECT_FALSE(link.calls().EmergencyStop("nobody hears"));
  ASSERT_TRUE(loop_.Until([&] { return !link.stats().connected; }));
  EXPECT_FALSE(link.stats().answers);
}

class DatagramLinkTest : public SlaveLinkTest {
 protected:
  SlaveLink::Options WithDatagrams(const std::string& target) const {
    SlaveLink::Options options = To(target);
    options.datagrams = true;
    return options;
  }
};

TEST_F(DatagramLinkTest, StatesAndCommandsTravelBothWaysAndTheNewestCounts) {
  std::vector<std::uint64_t> received;  // written by the link's threads, one at a time
  SlaveLink::Options options = WithDatagrams(server_->address());
  std::atomic<bool> keeps_keys{false};
  options.on_received = [&](const StateRecord& state) {
    received.push_back(state.message->sequence());
    if (state.message->has_datagrams()) keeps_keys = true;
  };
  StartedLink link(options, loop_);
  loop_.command.epoch = 1;
  loop_.command.engaged = true;
  ASSERT_TRUE(loop_.Until([&] {
    return link.stats().states_by_datagram > 50 && loop_.newest.state.phase == Phase::kFollowing;
  }));
  EXPECT_EQ(link.stats().trouble, "");
  EXPECT_GT(link.stats().delay.max_us, 0);
  link.Stop();
  EXPECT_FALSE(keeps_keys) << "the keys of the datagrams are neither recorded nor shown";
  EXPECT_TRUE(std::ranges::is_sorted(received, std::ranges::less_equal()))
      << "one came twice or late";
  const auto commands = slave_.commands();
  EXPECT_TRUE(std::ranges::is_sorted(commands, {}, &OperatorCommand::sequence));
  EXPECT_EQ(slave_.ends(), 1);
}

TEST_F(DatagramLinkTest, EventsArriveThoughDatagramsCarryNone) {
  for (const Event event : {Event::kContact, Event::kPuncture, Event::kRelease, Event::kLimit}) {
    std::atomic<bool> arrived{false};
    SlaveLink::Options options = WithDatagrams(server_->address());
    options.on_received = [&](const StateRecord& received) {
      if (FromProto(received.message->events()).Has(event)) arrived = true;
    };
    StartedLink link(options, loop_);
    const std::uint64_t before = link.stats().states_by_datagram;
    ASSERT_TRUE(loop_.Until([&] { return link.stats().states_by_datagram > before + 5; }));
    slave_.Happen(event);
    EXPECT_TRUE(loop_.Until([&] { return arrived.load(); }));
  }
}

void Fill(std::uint64_t sequence, v1::SlaveState* state) {
  const Time now = Clock::now();
  state->set_sequence(sequence);
  ToProto(now, state->mutable_sensed_at());
  ToProto(now, state->mutable_sent_at());
  state->mutable_p_s_tip();
}

// A slave whose states are changed by `alter`. It accepts operators while `accepts` is set.
class ScriptedPeer final : public v1::Teleoperation::Service {
 public:
  using Alter = std::function<void(v1::SlaveState*)>;
  explicit ScriptedPeer(Alter alter) : alter_(std::move(alter)) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address = "127.0.0.1:" + std::to_string(port);
  }
  grpc::Status Operate(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::SlaveState, v1::OperatorCommand>* stream) override {
    ++opened;
    if (!has_arm) return Error(v1::ERROR_REASON_NO_MANIPULATOR, "nobody can operate");
    if (!accepts) return {grpc::StatusCode::PERMISSION_DENIED, "role 'sensor' may not call this"};
    v1::SlaveState state;
    while (accepts && !context->IsCancelled()) {
      Fill(state.sequence() + 1, &state);
      alter_(&state);
      state.set_stops(stops);
      stream->Write(state);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return grpc::Status::OK;
  }
  grpc::Status WatchState(grpc::ServerContext* context, const v1::WatchStateRequest*,
                          grpc::ServerWriter<v1::SlaveState>* stream) override {
    v1::SlaveState state;
    while (!ends && !context->IsCancelled()) {
      Fill(state.sequence() + 1, &state);
      state.set_settings_revision(revision);
      state.set_stops(stops);
      state.set_phase(is_stopped ? v1::PHASE_ESTOP : v1::PHASE_OBSERVING);
      stream->Write(state);
      ++watched;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return grpc::Status::OK;
  }
  grpc::Status GetScene(grpc::ServerContext*, const v1::GetSceneRequest*,
                        v1::SceneDescription* scene) override {
    scene->set_settings_revision(revision);
    auto* mapping = scene->mutable_operator_();
    mapping->set_position_scale(1);
    mapping->set_force_scale(1);
    mapping->set_force_limit(3.3);
    for (const double q : {1, 0, 0, 0}) mapping->add_orientation(q);
    return grpc::Status::OK;
  }
  grpc::Status GetStatus(grpc::ServerContext*, const v1::GetStatusRequest*,
                         v1::Status* status) override {
    status->set_stops(stops);
    return grpc::Status::OK;
  }

  std::string address;
  std::atomic<std::uint64_t> stops{7};
  std::atomic<bool> is_stopped{false};  // as observers see it
  std::atomic<bool> accepts{true}, has_arm{true}, ends{false};
  std::atomic<std::uint32_t> revision{0};
  std::atomic<int> opened{0}, watched{0};  // streams of Operate, and states of WatchState

 private:
  const Alter alter_;
  std::unique_ptr<grpc::Server> server_;
};

// Offers datagrams with each state.
ScriptedPeer::Alter Offers(const v1::DatagramOffer& offer) {
  return [offer](v1::SlaveState* state) { *state->mutable_datagrams() = offer; };
}
v1::DatagramOffer OfferOf(unsigned port, std::size_t command_key, std::size_t state_key) {
  v1::DatagramOffer offer;
  offer.set_port(port);
  offer.set_command_key(std::string(command_key, 'c'));
  offer.set_state_key(std::string(state_key, 's'));
  return offer;
}

// A firewall blocks datagrams, or a slave offers an impossible port: the stream continues, and this
// is reported.
TEST_F(DatagramLinkTest, WithoutDatagramsTheStreamContinuesAndThisIsReported) {
  constexpr unsigned kNobody = 9, kBeyond = 65536 + 9;
  struct Pair {
    explicit Pair(const v1::DatagramOffer& offer) : slave(Offers(offer)) {}
    ScriptedPeer slave;
    Loop loop;
    std::unique_ptr<SlaveLink> link;
  };
  std::vector<std::unique_ptr<Pair>> pairs;
  for (const auto& offer : {OfferOf(kNobody, 32, 32), OfferOf(0, 32, 32), OfferOf(kBeyond, 32, 32),
                            OfferOf(kNobody, 31, 32), OfferOf(kNobody, 32, 0)}) {
    Pair& pair = *pairs.emplace_back(std::make_unique<Pair>(offer));
    pair.link = std::make_unique<SlaveLink>(WithDatagrams(pair.slave.address));
    pair.link->Connect();
    pair.link->Start(&pair.loop.states, &pair.loop.commands, &pair.loop.settings, true);
  }
  for (const auto& pair : pairs) {
    const SlaveLink& link = *pair->link;
    ASSERT_TRUE(pair->loop.Until([&] { return !link.stats().trouble.empty(); }));
    EXPECT_THAT(link.stats().trouble, HasSubstr("no datagrams come through"));
    const std::uint64_t states = link.stats().states;
    EXPECT_TRUE(pair->loop.Until([&] { return link.stats().states > states + 10; }));
    EXPECT_TRUE(link.stats().connected);
    EXPECT_EQ(link.stats().states_by_datagram, 0U);
    pair->slave.accepts = false;
  }
}

// States of seconds ago, of another session, of after the end: none of them is rendered.
TEST_F(DatagramLinkTest, OldAndLateDatagramsAreIgnored) {
  const DatagramLine::Keys keys{*DatagramKeyFrom(std::string(32, 's')),
                                *DatagramKeyFrom(std::string(32, 'c'))};
  sockaddr_storage at{};
  at.ss_family = AF_INET;
  reinterpret_cast<sockaddr_in&>(at).sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::atomic<int> commands{0};
  DatagramLine line(DatagramLine::Role::kAnswers, at, keys, [&](std::string_view) {
    ++commands;
    return DatagramLine::LinkFeedback{};
  });
  ScriptedPeer slave(Offers(OfferOf(line.port(), 32, 32)));
  StartedLink link(WithDatagrams(slave.address), loop_);
  ASSERT_TRUE(loop_.Until([&] { return commands > 0 && loop_.newest.state.sequence > 20; }));
  const auto send = [&](std::uint64_t sequence) {
    v1::SlaveState state;
    Fill(sequence, &state);
    state.mutable_force()->set_y(3);
    line.Send(state.SerializeAsString());
  };
  // Repeated, because only one in four of the first datagrams is sent.
  for (int i = 0; i < 5; ++i) {
    for (std::uint64_t sequence = 1; sequence < 20; ++sequence) send(sequence);
  }
  const std::uint64_t newest = loop_.newest.state.sequence;
  ASSERT_TRUE(loop_.Until([&] { return loop_.newest.state.sequence > newest + 20; }));
  EXPECT_EQ(link.stats().states_by_datagram, 0U);
  ASSERT_TRUE(loop_.Until([&] {
    send(1'000'000);
    return loop_.newest.state.sequence == 1'000'000;
  }));
  EXPECT_EQ(link.stats().states_by_datagram, 1U);
  slave.accepts = false;
  ASSERT_TRUE(loop_.Until([&] { return loop_.newest.ended; }));
  for (std::uint64_t sequence = 1'000'001; sequence < 1'000'100; ++sequence) send(sequence);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(loop_.Until([&] { return loop_.newest.ended; }));
  EXPECT_EQ(loop_.newest.state.sequence, 1'000'000U);
}

// A refused client needs another certificate and a restart. A client that was accepted before does
// not, since its certificate may be renewed.
TEST_F(SlaveLinkTest, WhoMayNotOperateGetsTheReason) {
  ScriptedPeer slave([](v1::SlaveState*) {});
  slave.accepts = false;
  SlaveLink link(To(slave.address));
  EXPECT_FALSE(link.denied());
  link.Start(&loop_.states, &loop_.commands, &loop_.settings, true);
  ASSERT_TRUE(loop_.Until([&] { return link.denied(); }));
  EXPECT_THAT(link.stats().trouble, HasSubstr("role 'sensor' may not call"));
  slave.accepts = true;
  ASSERT_TRUE(loop_.Until([&] { return link.stats().connected && !link.denied(); }));
  slave.accepts = false;
  ASSERT_TRUE(
      loop_.Until([&] { return link.stats().trouble.find("may not call") != std::string::npos; }));
  EXPECT_FALSE(link.denied());
}

// The lease is requested once, and again after a change of the scene or a cut of the link.
TEST_F(SlaveLinkTest, WhereNobodyCanOperateTheLeaseIsRequestedOnce) {
  ScriptedPeer slave([](v1::SlaveState*) {});
  slave.has_arm = false;
  slave.revision = 1;
  StartedLink link(To(slave.address), loop_);
  // States continue for 1.5 s after each request; the lease is requested every 0.5 s.
  const auto goes_on = [&] {
    const int before = slave.watched;
    return loop_.Until([&] { return slave.watched > before + 700; });
  };
  ASSERT_TRUE(goes_on());
  EXPECT_EQ(slave.opened, 1);
  EXPECT_TRUE(link.stats().observes);
  EXPECT_EQ(link.stats().trouble, "");
  slave.revision = 2;
  ASSERT_TRUE(loop_.Until([&] { return slave.opened == 2; }));
  ASSERT_TRUE(goes_on());
  EXPECT_EQ(slave.opened, 2);
  slave.ends = true;
  ASSERT_TRUE(loop_.Until([&] { return slave.opened == 3; }));
  slave.ends = false;
  slave.has_arm = true;
  slave.revision = 3;
  ASSERT_TRUE(loop_.Until([&] { return link.stats().connected; }));
  EXPECT_FALSE(link.stats().observes);
  slave.accepts = false;
}

// The operator decides to reset, and another client stops before the request arrives.
TEST_F(SlaveLinkTest, AResetClearsNoStopThatTheOperatorDidNotKnow) {
  StartedLink link(To(server_->address()), loop_);
  ASSERT_TRUE(loop_.Until([&] { return link.stats().connected; }));
  const auto known_stops = [&] { return link.state().message->stops(); };
  slave_.EmergencyStop("first");
  ASSERT_TRUE(loop_.Until([&] { return known_stops() == slave_.Status().stops; }));
  const std::uint64_t known = known_stops();
  slave_.EmergencyStop("second");
  EXPECT_THAT(link.calls().Reset(known), HasSubstr("newer stop"));
  EXPECT_EQ(slave_.Status().phase, Phase::kEstop);
  ASSERT_TRUE(loop_.Until([&] { return known_stops() == slave_.Status().stops; }));
  EXPECT_EQ(link.calls().Reset(known_stops()), "");
  EXPECT_NE(slave_.Status().phase, Phase::kEstop);
}

// A master that observes: its loop sees stop and reset in the states that it gets.
TEST_F(SlaveLinkTest, AnObserversLoopGetsTheStopAndItsEnd) {
  ScriptedPeer slave([](v1::SlaveState*) {});
  slave.has_arm = false;
  StartedLink link(To(slave.address), loop_);
  const auto sees = [&](Phase phase) {
    return loop_.Until([&] {
      const SlaveState& state = loop_.newest.state;
      return loop_.newest.observed && state.phase == phase && state.stops == slave.stops;
    });
  };
  slave.is_stopped = true;
  ++slave.stops;
  EXPECT_TRUE(sees(Phase::kEstop));
  slave.is_stopped = false;
  EXPECT_TRUE(loop_.Until([&] { return loop_.newest.state.phase != Phase::kEstop; }));
}

TEST_F(SlaveLinkTest, StatesThatCannotBeAreCountedReportedAndNeverHandedOn) {
  const ScriptedPeer peer([](v1::SlaveState* state) {
    state->mutable_p_s_tip()->set_x(std::numeric_limits<double>::quiet_NaN());
  });
  StartedLink link(To(peer.address), loop_);
  ASSERT_TRUE(loop_.Until([&] { return link.stats().refused > 3; }));
  EXPECT_THAT(link.stats().trouble, HasSubstr("a state was rejected: p_S_tip.x = nan"));
  EXPECT_EQ(link.stats().states, 0U);
  EXPECT_EQ(loop_.newest.received_at, Time{});
  EXPECT_FALSE(link.stats().connected);
  EXPECT_TRUE(loop_.Until([&] { return peer.opened > 1; })) << "they do not keep the line alive";
}

// The settings are read before each stream and again when a state reports a change.
TEST_F(SlaveLinkTest, SettingsAreReadBeforeTheStreamAndWhenTheyChange) {
  slave_.set_settings_revision(4);
  StartedLink link(To(server_->address()), loop_);
  const RemoteSettings* read = nullptr;
  const auto is_read = [&](std::uint32_t revision) {
    return [&, revision] {
      if (const RemoteSettings* newer = loop_.settings.Take()) read = newer;
      return read != nullptr && read->revision == revision;
    };
  };
  ASSERT_TRUE(loop_.Until(is_read(4)));
  EXPECT_EQ(read->force_limit, 3.3);
  slave_.SetParameters({.force_limit = 0.7});
  ASSERT_TRUE(loop_.Until(is_read(5)));
  EXPECT_EQ(read->force_limit, 0.7);
}

}  // namespace
}  // namespace palpate
