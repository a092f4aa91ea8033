// Emergency stops and their resets: tool and record always agree.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/live/operator_port.h"
#include "slave/live/stop_record.h"

namespace palpate {

// Thread-safe. An emergency stop that arrives at any moment of a reset remains, with its record.
class StopControl {
 public:
  // Both must outlive this object.
  StopControl(OperatorPort& port, StopRecord& record) : port_(port), record_(record) {}

  // Records why the tool was stopped, unless the stop is recorded or was reset. Returns empty, or
  // why the record is not saved yet. It may wait for the disk.
  std::string Record(const std::string& reason);
  // Removes the record of the emergency stop number `stops` and releases the tool. Throws
  // std::logic_error: another stop is the newest one; std::filesystem::filesystem_error: the record
  // cannot be removed. The stop and its record remain.
  void Reset(std::uint64_t stops);

 private:
  OperatorPort& port_;
  StopRecord& record_;
  PriorityInheritanceMutex mutex_;  // makes record and release of a stop one decision
};

}  // namespace palpate
