#include "tests/support/allocation_count.h"

#include <atomic>
#include <cstdlib>
#include <new>

// clang's thread sanitizer defines the operators itself as strong symbols, so its own hooks count
// the allocations.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define PALPATE_OPERATORS_ARE_TAKEN
#include <sanitizer/allocator_interface.h>
#endif
#endif

namespace {

std::atomic<long> count{0};
thread_local long own_count = 0;

void Count() {
  ++count;
  ++own_count;
}

}  // namespace

#ifdef PALPATE_OPERATORS_ARE_TAKEN
namespace {

const int installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { Count(); }, [](const volatile void*) {});

}  // namespace
#else
void* operator new(std::size_t size) {
  Count();
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  Count();
  return std::malloc(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
#endif

namespace palpate {

long AllocationCount() noexcept {
  return count;
}

long OwnAllocationCount() noexcept {
  return own_count;
}

}  // namespace palpate
