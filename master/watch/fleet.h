// The newest of each slave that publishes, for tables and programs.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/state/clock.h"
#include "shared/state/slave_state.h"

namespace palpate {

// SlaveLine describes one slave at an instant.
struct SlaveLine {
  std::string name;
  std::optional<double> force, sigma;  // [N]; nullopt: unknown
  // The validity has the words of CSV files. It is `silent` if the states have stopped, and
  // `unreadable` if they cannot be parsed.
  std::string validity;
  std::string check;          // that failed; empty: none
  std::string phase;          // of state.proto, in lower case; empty: there was no state
  std::optional<double> age;  // since its newest sample was taken [s]; without the network's delay
  double rate = 0;            // received states, over the last second or more [Hz]
  std::vector<std::string> alarms;
};

// Thread-safe. Text from slaves is printable and short.
class Fleet {
 public:
  // A slave is silent after this time without a state [s]: it sends 30 of them.
  static constexpr double kSilentAfter = 1;
  static constexpr std::size_t kMaxSlaves = 1000;  // slaves; others are not kept

  // Processes a message that arrived at `now`. Other kinds than `state` and `status` are ignored.
  void Take(std::string_view subject, std::string_view bytes, Time now);
  // Returns the slaves sorted by name. Rates count from the last call.
  std::vector<SlaveLine> Lines(Time now);

 private:
  struct Entry {
    std::optional<SlaveState> state;
    std::string unreadable;  // why; empty: it is readable
    Time came{}, counted{};
    int states = 0;  // since `counted`
    std::vector<std::string> alarms;
    std::optional<Time> started, doubled;  // of the program; when two were seen
  };

  static void TakeState(std::string_view bytes, Time now, Entry* entry);
  static void TakeStatus(std::string_view bytes, Time now, Entry* entry);
  static SlaveLine LineOf(const std::string& name, const Entry& entry, Time now);

  std::mutex mutex_;  // guards the next member
  std::map<std::string, Entry, std::less<>> entries_;
};

// Returns a line of titles, then one line for each slave.
std::vector<std::string> FleetTable(const std::vector<SlaveLine>& lines);
// Returns one object of JSON, in which unknown numbers are null.
std::string FleetJson(const SlaveLine& line);

}  // namespace palpate
