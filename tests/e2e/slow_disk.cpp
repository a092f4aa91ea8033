// Preloaded into a program: its disk takes 0.1 s to write or to remove a file for good.
#include <cstdio>

#include <dlfcn.h>
#include <unistd.h>

namespace {

constexpr useconds_t kDelay = 100'000;  // [us]

template <class Call>
Call Next(const char* name) {
  return reinterpret_cast<Call>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" int fsync(int file) {
  usleep(kDelay);
  return Next<int (*)(int)>("fsync")(file);
}

extern "C" int remove(const char* path) {
  usleep(kDelay);
  return Next<int (*)(const char*)>("remove")(path);
}
