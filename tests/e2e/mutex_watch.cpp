// This library is preloaded into a program. It lists mutexes without priority inheritance that
// real-time threads lock. It writes one line per caller in the program's own code (its offset in
// hexadecimal) to the file MUTEX_WATCH-PROGRAM-PID. A thread is real-time if it runs under
// SCHED_FIFO or requested it.
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <dlfcn.h>
#include <link.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

namespace {

constexpr int kInherits = 32;  // PTHREAD_MUTEX_PRIO_INHERIT_NP of glibc, in the kind of a mutex
constexpr std::size_t kCallers = 1024;

thread_local bool asked = false;
thread_local int realtime = -1;  // -1: not known yet
std::array<std::atomic<std::uintptr_t>, kCallers> callers;

bool IsRealtime() {
  if (realtime < 0) realtime = (sched_getscheduler(0) & ~SCHED_RESET_ON_FORK) == SCHED_FIFO;
  return asked || realtime == 1;
}

// Offset in the program; 0: elsewhere.
std::uintptr_t OffsetOf(const void* caller) {
  Dl_info place{};
  link_map* map = nullptr;
  if (dladdr1(caller, &place, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) == 0) return 0;
  const bool is_program = map->l_name == nullptr || map->l_name[0] == '\0';
  return is_program ? reinterpret_cast<std::uintptr_t>(caller) - map->l_addr : 0;
}

void Note(std::uintptr_t offset) {
  for (auto& one : callers) {
    std::uintptr_t none = 0;
    if (one == offset || one.compare_exchange_strong(none, offset) || none == offset) return;
  }
}

void Look(const pthread_mutex_t* mutex, const void* caller) {
  if (!IsRealtime() || (mutex->__data.__kind & kInherits) != 0) return;
  if (const std::uintptr_t offset = OffsetOf(caller); offset != 0) Note(offset);
}

template <class Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

struct Writer {
  ~Writer() {
    const char* prefix = std::getenv("MUTEX_WATCH");
    if (prefix == nullptr) return;
    const std::string name =
        std::string(prefix) + "-" + program_invocation_short_name + "-" + std::to_string(getpid());
    std::FILE* file = std::fopen(name.c_str(), "w");
    if (file == nullptr) return;
    for (const auto& one : callers) {
      if (one != 0) std::fprintf(file, "%zx\n", static_cast<std::size_t>(one));
    }
    std::fclose(file);
  }
} writer;

}  // namespace

extern "C" {

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static const auto next = Next<int (*)(pthread_mutex_t*)>("pthread_mutex_lock");
  Look(mutex, __builtin_return_address(0));
  return next(mutex);
}

int sched_setscheduler(pid_t pid, int policy, const sched_param* parameters) noexcept {
  static const auto next = Next<int (*)(pid_t, int, const sched_param*)>("sched_setscheduler");
  if (pid == 0) {
    asked = (policy & ~SCHED_RESET_ON_FORK) == SCHED_FIFO;
    realtime = 0;
  }
  return next(pid, policy, parameters);
}
}
