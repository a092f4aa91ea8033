// This library is preloaded into a program. It delays each permanent write or removal of a file by
// 0.1 s, or by SLOW_DISK_MS [ms].
#include <cstdio>
#include <cstdlib>

#include <dlfcn.h>
#include <unistd.h>

namespace {

void Wait() {
  const char* const delay_ms = std::getenv("SLOW_DISK_MS");
  usleep(1000 * (delay_ms != nullptr ? static_cast<useconds_t>(std::atoi(delay_ms)) : 100));
}

template <class Call>
Call Next(const char* name) {
  return reinterpret_cast<Call>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" int fsync(int file) {
  Wait();
  return Next<int (*)(int)>("fsync")(file);
}

extern "C" int remove(const char* path) {
  Wait();
  return Next<int (*)(const char*)>("remove")(path);
}
